"""Draws the pictures of the README.md files from the results of the benchmarks.

usage: plot.py FOLDER   with the result files; the pictures go there, too
"""

import json
import os
import sys

import matplotlib.pyplot as plt
from matplotlib.lines import Line2D
from matplotlib.text import Text

# Colours that colour-blind readers tell apart (Okabe, Ito, 2008); ours is the dark one.
COLOURS = {
    "ours": "#000000",
    "FCL libccd": "#D55E00",
    "FCL INDEP": "#E69F00",
    "libccd": "#CC79A7",
    "Bullet GJK": "#0072B2",
    "Bullet EPA2": "#56B4E9",
    "linear scan": "#999999",
    "FCL hulls": "#D55E00",
    "FCL hulls, INDEP": "#E69F00",
    "FCL triangles": "#CC79A7",
    "swept bisection": "#0072B2",
    "FCL advancement": "#D55E00",
    "FCL naive": "#E69F00",
    "sampling": "#999999",
}
# Hollow marks stay visible where they lie on each other.
MARKS = {
    "ours": "o",
    "FCL libccd": "s",
    "FCL INDEP": "^",
    "libccd": "D",
    "Bullet GJK": "v",
    "Bullet EPA2": "P",
    "swept bisection": "s",
    "FCL advancement": "^",
    "FCL naive": "D",
    "sampling": "v",
}
# How the pairs of a scene are settled, cheapest first.
RUNGS = {"unknown": "#999999", "at_rest": "#009E73", "by_motion": "#56B4E9", "by_bounds": "#0072B2", "computed": "#D55E00"}
LEGEND_ROOM = 0.965  # of the height is left to the panels below a legend
SMALLEST = 1e-17  # [m] an error of 0 has no logarithm


def style(library):
    return {"color": COLOURS.get(library, "#009E73"), "linewidth": 2.5 if library == "ours" else 1.2}


def mark(library, size=6):
    """Returns the mark of a library in a panel that has no room for names: legend_of() says which is whose."""
    is_ours = library == "ours"
    return {"marker": MARKS.get(library, "X"), "markersize": size + 1 if is_ours else size, "markeredgewidth": 1.3,
            "markerfacecolor": style(library)["color"] if is_ours else "none"}


def legend_of(figure, libraries, size=6, linestyle="-"):
    """Draws one legend above all panels."""
    handles = [Line2D([], [], linestyle=linestyle, **style(library), **mark(library, size)) for library in libraries]
    figure.legend(handles, libraries, loc="upper center", ncols=len(libraries), fontsize=9, frameon=False)


def known_first(entries):
    """Returns the libraries of some entries, in the order of COLOURS."""
    found = {entry["library"] for entry in entries}
    return [library for library in COLOURS if library in found] + sorted(found - set(COLOURS))


def label_last(axes, xs, ys, library, above=0):
    axes.annotate(library, (xs[-1], ys[-1]), xytext=(4, above), textcoords="offset points", fontsize=8,
                  color=style(library)["color"], va="center")


def time_against_error(results, file):
    """Draws a panel for each workload, a mark for each library; down and left is better."""
    workloads = [f"{solid}, {placement}" for solid in ("box", "cylinder", "hull 32", "hull 200")
                 for placement in ("apart", "shallow", "deep")]
    figure, panels = plt.subplots(4, 3, figsize=(11, 12), sharex=True, sharey=True)
    for panel, workload in zip(panels.flat, workloads):
        panel.set_title(workload, fontsize=10)
        for entry in (e for e in results["rows"] if e["row"] == workload):
            library = entry["library"]
            x, y = entry["ns"], max(entry["max_error"], SMALLEST)
            panel.plot(x, y, linestyle="", color=style(library)["color"], **mark(library, 8))
        panel.set(xscale="log", yscale="log", xlim=(1e2, 1e6), ylim=(3e-19, 30))
        panel.grid(alpha=0.3)
    legend_of(figure, known_first(e for e in results["rows"] if e["row"] in workloads), 8, "")
    figure.supxlabel("time per query [ns]")
    figure.supylabel("largest error [m], solids of size 1")
    save(figure, file, LEGEND_ROOM)


def time_against_tolerance(results, file):
    """Draws what a tighter tolerance costs and brings, a line for each library."""
    workloads = list(dict.fromkeys(e["row"] for e in results["tolerances"]))
    figure, panels = plt.subplots(2, 4, figsize=(14, 7), sharex=True, sharey=True)
    for panel, workload in zip(panels.T.flat, workloads):
        panel.set_title(workload, fontsize=10)
        entries = [e for e in results["tolerances"] if e["row"] == workload]
        for library in dict.fromkeys(e["library"] for e in entries):
            line = sorted((e for e in entries if e["library"] == library), key=lambda e: -e["tolerance"])
            xs, ys = [e["ns"] for e in line], [max(e["max_error"], SMALLEST) for e in line]
            panel.plot(xs, ys, **style(library), **mark(library))
        panel.set(xscale="log", yscale="log", xlim=(1e2, 3e6), ylim=(1e-18, 30))
        panel.grid(alpha=0.3)
    legend_of(figure, known_first(results["tolerances"]))
    figure.supxlabel("time per query [ns], tolerances from 1e-2 to 1e-14 m")
    figure.supylabel("largest error [m]")
    save(figure, file, LEGEND_ROOM)


def time_against_vertices(results, file):
    """Draws the time of the distance of two hulls apart, and of the support mapping alone."""
    figure, (query, support) = plt.subplots(1, 2, figsize=(12, 5))
    distances = [e for e in results["vertices"] if e["row"] == "hulls by vertices"]
    for library in dict.fromkeys(e["library"] for e in distances):
        line = [e for e in distances if e["library"] == library]
        xs, ys = [e["vertices"] for e in line], [e["ns"] for e in line]
        query.plot(xs, ys, ".-", **style(library))
        label_last(query, xs, ys, library)
    query.set_title("distance of two hulls, cold", fontsize=10)
    line = [e for e in results["vertices"] if e["row"] == "support by vertices"]
    xs = [e["vertices"] for e in line]
    for library, key in (("ours", "ns"), ("linear scan", "scan_ns")):
        ys = [e[key] for e in line]
        support.plot(xs, ys, ".-", **style(library))
        label_last(support, xs, ys, library)
    support.set_title("support mapping alone", fontsize=10)
    for axes in (query, support):
        axes.set(xscale="log", yscale="log", xlim=(6, 8e5), xlabel="vertices of each hull", ylabel="time [ns]")
        axes.grid(alpha=0.3)
    save(figure, file)


def subalgorithms(results, file):
    """Draws time and GJK error of the ways to find the nearest point of a simplex, by kind of simplex."""
    entries = results["subalgorithms"]
    kinds = list(dict.fromkeys(e["simplices"] for e in entries))
    names = list(dict.fromkeys(e["algorithm"] for e in entries))
    colours = ["#D55E00", "#E69F00", "#000000", "#0072B2"]
    figure, (time, error) = plt.subplots(1, 2, figsize=(12, 5))
    for k, name in enumerate(names):
        line = {e["simplices"]: e for e in entries if e["algorithm"] == name}
        places = [i + 0.2 * (k - 1.5) for i in range(len(kinds))]
        time.bar(places, [line[kind]["ns"] for kind in kinds], 0.2, color=colours[k % 4], label=name)
        error.bar(places, [max(line[kind]["max_error"], SMALLEST) for kind in kinds], 0.2, color=colours[k % 4])
    error.set(yscale="log", ylabel="largest error / largest vertex norm")
    time.set(ylabel="time of one simplex [ns]")
    time.set_ylim(0, 1.35 * max(e["ns"] for e in entries))
    time.legend(fontsize=8, ncols=2, loc="upper left")
    for axes in (time, error):
        axes.set_xticks(range(len(kinds)), kinds, rotation=20, fontsize=8)
    save(figure, file)


def stability(results, file):
    """Draws the worst that the stress pairs of each family showed, and how many of them were looked at."""
    families = results["families"][::-1]
    places = range(len(families))
    figure, (error, gap, iterations) = plt.subplots(1, 3, figsize=(12, 7), sharey=True)
    for axes, key, title in ((error, "worst_error", "largest error / size"), (gap, "worst_gap", "widest bounds / size"),
                             (iterations, "most_iterations", "most iterations")):
        axes.plot([max(family[key], SMALLEST) for family in families], places, "o", color=COLOURS["ours"])
        axes.set(xscale="log", title=title)
        axes.grid(alpha=0.3)
    for axes in (error, gap):
        axes.set_xlim(SMALLEST / 2, 10.0)
    error.set_yticks(places, [f"{family['family']} ({family['pairs']:,})" for family in families], fontsize=8)
    failures = sum(family["failures"] for family in families)
    figure.suptitle(f"{results['pairs']:,} pairs, {failures} failures", fontsize=10)
    save(figure, file)


def scene_scaling(results, file):
    """Draws the minimum of arms side by side: time of a state, and how many pairs there are, in reach and computed."""
    figure, panels = plt.subplots(2, 2, figsize=(12, 9), sharex=True, sharey="row")
    for (time, count), motion in zip(panels.T, ("coherent", "cold")):
        entries = [e for e in results["scaling"] if e["motion"] == motion]
        for library in dict.fromkeys(e["library"] for e in entries):
            line = [e for e in entries if e["library"] == library]
            xs, ys = [e["bodies"] for e in line], [e["median_us"] for e in line]
            time.plot(xs, ys, ".-", **style(library))
            label_last(time, xs, ys, library)
        line = [e for e in entries if e["library"] == "ours"]
        xs = [e["bodies"] for e in line]
        for name, values, colour in (("all pairs", [e["pairs"] for e in line], "#999999"),
                                     ("boxes in reach", [e["pairs_in_reach"] for e in line], "#0072B2"),
                                     ("computed by ours", [e["counts"]["computed"] for e in line], "#000000")):
            count.plot(xs, values, ".-", color=colour)
            count.annotate(name, (xs[-1], values[-1]), xytext=(4, 0), textcoords="offset points", fontsize=8,
                           color=colour, va="center")
        time.set_title(f"minimum, {motion}", fontsize=10)
        count.set_xlabel("bodies")
        for axes in (time, count):
            axes.set(xscale="log", yscale="log", xlim=(1.8, 4000))
            axes.grid(alpha=0.3)
    panels[0][0].set_ylabel("median time of a state [us]")
    panels[1][0].set_ylabel("pairs")
    save(figure, file)


def scene_rungs(results, file):
    """Draws how the pairs of each robot were settled: the shares of the rungs."""
    entries = [e for e in results["rows"] if e["library"] == "ours"][::-1]
    figure, axes = plt.subplots(figsize=(10, 0.3 * len(entries) + 1.2))
    left = [0.0] * len(entries)
    for rung, colour in RUNGS.items():
        shares = [100.0 * e["counts"][rung] / e["counts"]["total"] for e in entries]
        axes.barh(range(len(entries)), shares, left=left, color=colour, label=rung.replace("_", " "))
        left = [before + share for before, share in zip(left, shares)]
    axes.set_yticks(range(len(entries)), [f"{e['row']} ({e['pairs']} pairs)" for e in entries], fontsize=8)
    axes.set(xlim=(0, 100), xlabel="% of the pairs")
    axes.margins(y=0.01)
    axes.legend(fontsize=8, ncols=len(RUNGS), loc="lower center", bbox_to_anchor=(0.5, 1.0))
    save(figure, file)


def motion_time_against_error(results, file):
    """Draws what a tighter setting of the time of contact costs and brings, a line for each library. A cross
    marks settings with which contacts were missed or found late."""
    solids, motions = ("box", "cylinder", "hull 200", "plate"), ("translation", "linear", "screw")
    figure, panels = plt.subplots(3, 4, figsize=(14, 10), sharex=True, sharey=True)
    for panel, workload in zip(panels.flat, [f"{solid}, {motion}, hit" for motion in motions for solid in solids]):
        panel.set_title(workload, fontsize=10)
        entries = [e for e in results["tolerances"] if e["row"] == workload and "ns" in e]
        for library in dict.fromkeys(e["library"] for e in entries):
            line = [e for e in entries if e["library"] == library]
            xs, ys = [e["ns"] for e in line], [max(e["max_error"], SMALLEST) for e in line]
            panel.plot(xs, ys, **style(library), **mark(library, 5))
            wrong = [(x, y) for x, y, e in zip(xs, ys, line) if e["missed"] or e["late"]]
            panel.plot(*zip(*wrong) if wrong else ((), ()), "x", color=style(library)["color"], markersize=10)
        panel.set(xscale="log", yscale="log", xlim=(3e2, 3e8), ylim=(SMALLEST / 10, 30))
        panel.grid(alpha=0.3)
    legend_of(figure, known_first(results["tolerances"]))
    figure.supxlabel("time per motion [ns]; x: contacts missed or late")
    figure.supylabel("largest error [m] at the time of contact, solids of size 1")
    save(figure, file, LEGEND_ROOM)


def ticks_out_of_view(figure):
    """Yields the labels of ticks that are there but not drawn."""
    for axis in (axis for axes in figure.axes for axis in (axes.xaxis, axes.yaxis)):
        first, last = sorted(axis.get_view_interval())
        for tick in axis.get_major_ticks() + axis.get_minor_ticks():
            if not first <= tick.get_loc() <= last:
                yield from (tick.label1, tick.label2)


def overlapping_labels(figure):
    """Returns the pairs of texts of the drawn figure that cover each other; a common edge does not count."""
    renderer = figure.canvas.get_renderer()
    hidden = set(ticks_out_of_view(figure))
    labels = [text for text in figure.findobj(Text)
              if text.get_visible() and text.get_text().strip() and text not in hidden]
    boxes = [text.get_window_extent(renderer).padded(-0.5) for text in labels]
    return [(labels[i].get_text(), labels[j].get_text()) for i in range(len(labels)) for j in range(i)
            if boxes[i].overlaps(boxes[j])]


def save(figure, file, top=1.0):
    """`top`: how much of the height the panels take. Ends the program where labels cannot be read."""
    figure.tight_layout(rect=(0.0, 0.0, 1.0, top))
    figure.canvas.draw()
    if overlap := overlapping_labels(figure):
        sys.exit(f"{file}: labels overlap: {overlap}")
    figure.savefig(file, dpi=80)
    print(file)


PICTURES = {  # what is drawn of which results
    "time_against_error": (time_against_error, "narrowphase"),
    "time_against_tolerance": (time_against_tolerance, "narrowphase"),
    "time_against_vertices": (time_against_vertices, "narrowphase"),
    "subalgorithms": (subalgorithms, "subalgorithms"),
    "stability": (stability, "stress"),
    "scene_scaling": (scene_scaling, "scene"),
    "scene_rungs": (scene_rungs, "scene"),
    "motion_time_against_error": (motion_time_against_error, "motion"),
}


def main(folder):
    for name, (draw, suite) in PICTURES.items():
        with open(os.path.join(folder, f"{suite}.json")) as file:
            results = json.load(file)
        draw(results, os.path.join(folder, f"{name}.png"))


if __name__ == "__main__":
    main(sys.argv[1])
