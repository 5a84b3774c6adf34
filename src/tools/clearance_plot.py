#!/usr/bin/python3
"""clearance_plot.py DATA.csv PICTURE.png LIMIT: the rows of `clearance` as a picture, and a line at the clearance LIMIT
[m]; without arguments: whether it can."""
import csv
import sys

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402  (after the choice of the backend)
import numpy  # noqa: E402

SHOWN_PAIRS = 20  # more rows of a heat map cannot be read
COLUMNS = 1000  # wider than the picture has pixels
FEW = 50  # states or segments, of which each can be seen


def read_rows(path):
    with open(path, newline="") as stream:
        return list(csv.DictReader(stream))


def pair_name(row):
    return row["link_a"] + " - " + row["link_b"]


def two_panels(pairs, limit):
    """The clearance above, a line for each pair below."""
    figure, (above, below) = plt.subplots(
        2, 1, figsize=(10, 4 + 0.25 * len(pairs)), sharex=True, constrained_layout=True)
    above.axhline(limit, color="red", linewidth=0.8)
    above.set_ylabel("clearance [m]")
    below.set_yticks(range(len(pairs)))
    below.set_yticklabels(pairs, fontsize=7)
    return figure, above, below


def distances_of(rows):
    """Distance by pair and state, [m]."""
    pairs = {}
    for row in rows:
        pairs.setdefault(pair_name(row), {})[int(row["state"])] = float(row["distance"])
    return pairs


def heat_map(pairs, states):
    """One row a pair, the smallest distance of the states that share a column; NaN where the pair was not listed."""
    columns = min(states, COLUMNS)
    picture = numpy.full((len(pairs), columns), numpy.nan)
    for row, distances in zip(picture, pairs):
        for state, distance in distances.items():
            column = state * columns // states
            row[column] = numpy.fmin(row[column], distance)
    return picture


def draw_states(rows, limit):
    pairs = distances_of(rows)
    states = 1 + max(state for distances in pairs.values() for state in distances)
    clearance = numpy.full(states, numpy.nan)
    for distances in pairs.values():
        for state, distance in distances.items():
            clearance[state] = numpy.fmin(clearance[state], distance)
    closest = sorted(pairs, key=lambda name: min(pairs[name].values()))[:SHOWN_PAIRS]

    figure, above, below = two_panels(closest, limit)
    above.plot(clearance, linewidth=1, marker="." if states < FEW else "")
    image = below.imshow(heat_map([pairs[name] for name in closest], states), aspect="auto", cmap="viridis",
                         interpolation="nearest", extent=(-0.5, states - 0.5, len(closest) - 0.5, -0.5))
    below.set_yticks(range(len(closest)))
    below.set_xlabel("state")
    figure.colorbar(image, ax=below, label="distance [m]")
    return figure


def column(rows, name):
    return numpy.array([float(row[name]) for row in rows])


def draw_clearance(rows, axes):
    """The bounds of each segment as a band, the place of its minimum, and from its first contact on a red bar."""
    begin, end, lower, upper = (column(rows, name) for name in ("t_begin", "t_end", "lower", "upper"))
    known = numpy.isfinite(lower) & numpy.isfinite(upper)
    axes.bar(begin[known], (upper - lower)[known], (end - begin)[known], lower[known], align="edge", alpha=0.4,
             edgecolor="C0", linewidth=1, label="bounds of the minimum")
    axes.plot(column(rows, "t_minimum"), column(rows, "distance"), linewidth=0.5, color="C0",
              marker="." if len(rows) < FEW else "", label="minimum")
    unknown = [row for row in rows if row["contact"] == "unknown"]
    for shown, begins, color, label in (
            ([row for row in rows if row["contact"] == "true"], "t_contact", "red", "from first contact"),
            (unknown, "t_free", "grey", "contact not known")):
        spans = [(float(row[begins]), float(row["t_end"]) - float(row[begins])) for row in shown]
        if spans:
            axes.broken_barh(spans, (0, 1), transform=axes.get_xaxis_transform(), color=color, alpha=0.15, label=label)
            axes.vlines([begin for begin, _ in spans], 0, 1, transform=axes.get_xaxis_transform(), color=color,
                        linewidth=0.8)
    axes.legend(fontsize=7)


def draw_segments(rows, limit):
    known = [row for row in rows if row["link_a"]]
    smallest = {}
    for row in known:
        smallest[pair_name(row)] = min(float(row["lower"]), smallest.get(pair_name(row), numpy.inf))
    closest = sorted(smallest, key=smallest.get)[:SHOWN_PAIRS]

    figure, above, below = two_panels(closest, limit)
    draw_clearance(rows, above)
    shown = [row for row in known if pair_name(row) in closest]
    lines = below.hlines([closest.index(pair_name(row)) for row in shown], column(shown, "t_begin"),
                         column(shown, "t_end"), linewidth=8, cmap="viridis")
    lines.set_capstyle("butt")
    lines.set_array(column(shown, "distance"))
    below.set_ylim(len(closest) - 0.5, -0.5)
    below.set_xlabel("time [s]")
    figure.colorbar(lines, ax=below, label="distance [m]")
    return figure


def draw(rows, limit):
    return draw_segments(rows, limit) if "segment" in rows[0] else draw_states(rows, limit)


if __name__ == "__main__":
    if len(sys.argv) == 4:
        found = read_rows(sys.argv[1])
        if not found:
            sys.exit("no pair was listed in any state: nothing to draw")
        draw(found, float(sys.argv[3])).savefig(sys.argv[2], dpi=100, format="png")
