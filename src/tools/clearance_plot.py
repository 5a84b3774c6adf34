#!/usr/bin/python3
"""clearance_plot.py DATA.csv PICTURE.png: the rows of `clearance` as a picture; without arguments: whether it can."""
import csv
import sys

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402  (after the choice of the backend)
import numpy  # noqa: E402

SHOWN_PAIRS = 20  # more rows of a heat map cannot be read
COLUMNS = 1000  # wider than the picture has pixels


def read_rows(path):
    """Distance by pair and state, [m]."""
    pairs = {}
    with open(path, newline="") as stream:
        for row in csv.DictReader(stream):
            name = row["link_a"] + " - " + row["link_b"]
            pairs.setdefault(name, {})[int(row["state"])] = float(row["distance"])
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


def draw(pairs, path):
    states = 1 + max(state for distances in pairs.values() for state in distances)
    clearance = numpy.full(states, numpy.nan)
    for distances in pairs.values():
        for state, distance in distances.items():
            clearance[state] = numpy.fmin(clearance[state], distance)
    closest = sorted(pairs, key=lambda name: min(pairs[name].values()))[:SHOWN_PAIRS]

    figure, (above, below) = plt.subplots(
        2, 1, figsize=(10, 4 + 0.25 * len(closest)), sharex=True, constrained_layout=True)
    above.plot(clearance, linewidth=1, marker="." if states < 50 else "")
    above.axhline(0.0, color="red", linewidth=0.8)
    above.set_ylabel("clearance [m]")
    image = below.imshow(heat_map([pairs[name] for name in closest], states), aspect="auto", cmap="viridis",
                         interpolation="nearest", extent=(-0.5, states - 0.5, len(closest) - 0.5, -0.5))
    below.set_yticks(range(len(closest)))
    below.set_yticklabels(closest, fontsize=7)
    below.set_xlabel("state")
    figure.colorbar(image, ax=below, label="distance [m]")
    figure.savefig(path, dpi=100, format="png")


if __name__ == "__main__":
    if len(sys.argv) == 3:
        found = read_rows(sys.argv[1])
        if not found:
            sys.exit("no pair was listed in any state: nothing to draw")
        draw(found, sys.argv[2])
