#!/usr/bin/python3
"""clearance_plot.py DATA.csv FORMAT LIMIT: the rows of `clearance` as a picture (png, pdf or svg) on standard output, and
a line at the clearance LIMIT [m]; without arguments: whether it can."""
import csv
import sys

try:
    import matplotlib
    matplotlib.use("Agg")
    import matplotlib.pyplot as plt
    import numpy
except ImportError as error:
    sys.exit(str(error))

SHOWN_PAIRS = 20  # the most rows of a heat map that can be read
COLUMNS = 1000  # more than the picture has pixels in a row
BAND = 0.05  # height of the band that marks contacts, as a share of the panel
FEW = 50  # fewer states or segments have visible markers


def read_rows(path):
    with open(path, newline="") as stream:
        return list(csv.DictReader(stream))


def pair_name(row):
    return row["link_a"] + " - " + row["link_b"]


def two_panels(pairs, limit):
    """A figure with a panel for the clearance above, and a panel with a row for each pair below."""
    figure, (above, below) = plt.subplots(
        2, 1, figsize=(10, 4 + 0.25 * len(pairs)), sharex=True, constrained_layout=True)
    above.axhline(limit, color="red", linewidth=0.8)
    above.set_ylabel("clearance [m]")
    below.set_yticks(range(len(pairs)))
    below.set_yticklabels(pairs, fontsize=7)
    return figure, above, below


def distances_of(rows):
    """The distances [m] by pair and state."""
    pairs = {}
    for row in rows:
        pairs.setdefault(pair_name(row), {})[int(row["state"])] = float(row["distance"])
    return pairs


def heat_map(pairs, states):
    """A row for each pair: the smallest distance of the states that share a column; NaN if the pair was not listed."""
    columns = min(states, COLUMNS)
    picture = numpy.full((len(pairs), columns), numpy.nan)
    for row, distances in zip(picture, pairs):
        for state, distance in distances.items():
            column = state * columns // states
            row[column] = numpy.fmin(row[column], distance)
    return picture


def draw_states(rows, limit):
    pairs = distances_of(row for row in rows if row["link_a"])  # a state without an answer has no pair
    states = 1 + max(int(row["state"]) for row in rows)
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


def mark_spans(axes, rows, begin_name, color, label):
    """Marks the time from a column of each of these rows to the end of its segment, in a band below the curve."""
    begins = column(rows, begin_name)
    axes.broken_barh(list(zip(begins, column(rows, "t_end") - begins)), (0, BAND), facecolor=color, label=label,
                     transform=axes.get_xaxis_transform())


def draw_clearance(rows, axes):
    """Draws the two bounds of each segment's minimum, the place of the minimum, and in red the time after a contact."""
    begin, end = column(rows, "t_begin"), column(rows, "t_end")
    axes.hlines(column(rows, "lower"), begin, end, linewidth=1, label="minimum of the segment, both bounds")
    axes.hlines(column(rows, "upper"), begin, end, linewidth=1)
    axes.plot(column(rows, "t_minimum"), column(rows, "distance"), linestyle="", color="C1", marker=".",
              markersize=6 if len(rows) < FEW else 2, label="where it is")
    bottom, top = axes.get_ylim()
    axes.set_ylim(bottom - 2.0 * BAND * (top - bottom), top)  # space for the band, whose height has no meaning
    for contact, begins, color, label in (("true", "t_contact", "red", "from the first contact of the segment"),
                                          ("unknown", "t_free", "grey", "contact not known")):
        marked = [row for row in rows if row["contact"] == contact]
        if marked:
            mark_spans(axes, marked, begins, color, label)
    axes.legend(fontsize=7, loc="lower left", bbox_to_anchor=(0.0, 1.0), ncol=4)


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
        data, picture_format, clearance = sys.argv[1:]
        found = read_rows(data)
        if not any("segment" in row or row["link_a"] for row in found):
            sys.exit("no pair was listed in any state: nothing to draw")
        try:
            draw(found, float(clearance)).savefig(sys.stdout.buffer, dpi=100, format=picture_format)
            sys.stdout.flush()
        except OSError as error:
            sys.exit(str(error))
