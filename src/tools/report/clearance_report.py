#!/usr/bin/python3
"""clearance_report.py DATA.json html: the facts that `clearance --report` has collected as one page without links to other
files (XHTML with pictures in SVG) on standard output; without arguments: whether it can. The same facts and the same
matplotlib give the same bytes."""
import html
import io
import json
import re
import shlex
import sys
import warnings

try:
    import matplotlib
    matplotlib.use("Agg")
    import matplotlib.pyplot as plt
    import numpy
    from matplotlib.collections import PolyCollection
    from matplotlib.colors import to_rgba
except ImportError as error:
    sys.exit(str(error))

# Colours that people with any colour vision tell apart (Okabe and Ito, Color Universal Design, 2008); each has a marker.
LEVELS = {"CLEAR": ("#56B4E9", "."), "WARN": ("#E69F00", "^"), "STOP": ("#D55E00", "s"), "COLLISION": ("#000000", "X")}
BLUE, ORANGE = "#0072B2", "#E69F00"
COLUMNS = 300  # the most points of the curve
STEPS = 1000  # the most of a trajectory's curve
NEAR = 0.2  # [m] the darkest colour of the matrix is contact, the brightest one this distance or more
GAPS = (0.0, 0.01, 0.025, 0.05, 0.1)  # [m] of the shares
MOST_NUMBERS, MOST_WORDS = 14, 60  # rows of a matrix with numbers, and with marks in its cells
MOST_OUTLINES = 60  # of a view that stays a drawing; with more it is an image
STYLE = """
body{font:16px/1.45 sans-serif;color:#000;background:#fff;max-width:60rem;margin:0 auto;padding:0 1rem 3rem}
h1{font-size:1.6rem;line-height:1.2}h2{font-size:1.25rem;margin-top:2.2rem;border-bottom:1px solid #888}h3{font-size:1rem}
table{border-collapse:collapse;font-size:.875rem}td,th{border-bottom:1px solid #bbb;padding:.2rem .6rem .2rem 0;
text-align:left;vertical-align:top;overflow-wrap:break-word}td.n,th.n{text-align:right;white-space:nowrap}
code,dd,p,li,h1,h3{overflow-wrap:anywhere}code{font-size:.875em}td code{font-size:1em}.mesh{min-width:11rem;overflow-wrap:anywhere}
.wide{overflow-x:auto;background:linear-gradient(90deg,#fff 1rem,#fff0) 0/3rem 100% no-repeat local,
linear-gradient(270deg,#fff 1rem,#fff0) 100%/3rem 100% no-repeat local,linear-gradient(90deg,#0006,#0000) 0/.8rem 100% no-repeat scroll,
linear-gradient(270deg,#0006,#0000) 100%/.8rem 100% no-repeat scroll}.wide svg{min-width:30rem}
svg{display:block;width:100%;height:auto;max-width:46rem}.views{display:flex;flex-wrap:wrap;gap:.5rem}
.views svg{flex:1 1 13rem;width:13rem;max-width:20rem}.key{font-size:1.1rem}dt{font-weight:bold}dd{margin:0 0 .5rem}
@media print{body{font-size:9pt;max-width:none;padding:0}h2,h3,h2+p{break-after:avoid}svg,tr,.moment{break-inside:avoid}
table{font-size:8pt}td,th{padding-top:0;padding-bottom:0}p{margin:.4em 0}h2{margin-top:1.2rem}.moment code{font-size:7pt}
.views{flex-wrap:nowrap}.views svg{flex:1 1 0;min-width:0;max-width:5.8cm}.wide{overflow:visible}.wide svg{min-width:0;max-width:15cm}
@page{size:A4;margin:15mm}}
"""


def clean(name):
    """Without the characters that XML forbids."""
    return re.sub("[\0-\x08\x0b\x0c\x0e-\x1f\ufffe\uffff]", "\N{REPLACEMENT CHARACTER}", str(name))


def text(name):
    return html.escape(clean(name))


def label(name):
    """For matplotlib, which reads what stands between dollars as a formula."""
    return clean(name).replace("$", r"\$")


def code(words):
    return "<code>" + text(words) + "</code>"


def mm(metres):
    """A length in millimetres; unknown: an en dash."""
    if metres is None:
        return "\N{EN DASH}"
    return f"{0.0 if abs(metres) < 5e-7 else 1000.0 * metres:.3f}".replace("-", "\N{MINUS SIGN}")


def pair_name(pair):
    return f"{pair['link_a']} \N{EN DASH} {pair['link_b']}"


def table(heads, rows):
    """Cells are XHTML. The heads of columns of numbers begin with '#'."""
    kinds = [' class="n"' if head.startswith("#") else "" for head in heads]
    line = "<tr>" + "".join(f"<th{kind}>{head.lstrip('#')}</th>" for kind, head in zip(kinds, heads)) + "</tr>"
    body = "".join("<tr>" + "".join(f"<td{kind}>{cell}</td>" for kind, cell in zip(kinds, row)) + "</tr>\n" for row in rows)
    return f'<div class="wide"><table><thead>{line}</thead><tbody>\n{body}</tbody></table></div>\n'


def svg_of(figure, name, number):
    """The drawing as an element of the page; the number keeps its ids apart from the ids of all others."""
    stream = io.StringIO()
    figure.savefig(stream, format="svg", metadata={"Date": None}, facecolor="none")
    plt.close(figure)
    svg = stream.getvalue()
    svg = re.sub(r"<metadata>.*?</metadata>|<style.*?</style>", "", svg[svg.index("<svg"):], flags=re.DOTALL)
    svg = re.sub(r'( id="|url\(#|href="#)', rf"\g<1>p{number}-", svg)
    return svg.replace("<svg ", f'<svg role="img" aria-label="{text(name)}" ', 1)


def place(pair, facts):
    """The state of a pair, or its time along a trajectory."""
    seconds = "" if pair["time"] is None else f"{pair['time']:.4f}".rstrip("0").rstrip(".") + " s"
    if facts["rows"] == "segment":
        return f"{seconds} (segment {pair['segment']})"
    return f"state {pair['state']}" + (f" ({seconds})" if seconds else "")


def array(facts, name):
    return numpy.array(facts["curves"].get(name, []), dtype=float)


def closest_of_parts(lower):
    """The places with the smallest values of at most COLUMNS parts; those without a value are left out."""
    parts = numpy.array_split(numpy.arange(len(lower)), min(len(lower), COLUMNS))
    return numpy.array([part[numpy.nanargmin(lower[part])] for part in parts if numpy.isfinite(lower[part]).any()], dtype=int)


def curve_of_states(axes, facts):
    """The smallest distance of each state, with markers for the levels; of many states the closest and the worst ones."""
    distance, lower, level = (array(facts, name) for name in ("distance", "lower", "level"))
    at = closest_of_parts(lower)
    axes.set_xlabel("state" if len(at) == len(lower) else f"state (the closest of each {-(-len(lower) // COLUMNS)})")
    is_way = not facts["asked"]["states"]["identity"].startswith("sample")  # the order of samples means nothing
    axes.plot(at, 1e3 * distance[at], color=BLUE, linewidth=0.8 * is_way, label="smallest distance",
              marker="" if is_way else ".", markersize=3)
    if (distance - lower > 1e-6).any():
        axes.plot(at, 1e3 * lower[at], color=BLUE, linewidth=0.8, linestyle="--", label="proven lower bound")
    worst = closest_of_parts(lower - 1e6 * level)
    for number, (name, (color, marker)) in enumerate(LEVELS.items()):
        chosen = worst[level[worst] == number]
        if len(chosen) and facts["settings"]["thresholds"]:
            axes.plot(chosen, 1e3 * distance[chosen], linestyle="", color=color, marker=marker, markersize=5, label=name)
    return numpy.flatnonzero(numpy.isnan(lower))


def curve_of_segments(axes, facts):
    """The proven minimum over time as steps; neighbours of many share a step. Markers: where each segment is closest."""
    begin, end, lower, time, distance, contact, t_contact = (
        array(facts, name) for name in ("begin", "end", "lower", "time", "distance", "contact", "t_contact"))
    steps = [part for part in numpy.array_split(numpy.arange(len(lower)), min(len(lower), STEPS)) if len(part)]
    smallest = [numpy.nan if numpy.isnan(lower[part]).all() else numpy.nanmin(lower[part]) for part in steps]
    axes.set_xlabel("time [s]")
    axes.step([begin[part[0]] for part in steps] + [end[-1]], 1e3 * numpy.array(smallest + smallest[-1:]), where="post",
              color=BLUE, linewidth=1.0, label="proven minimum")
    axes.plot(time, 1e3 * distance, linestyle="", color="black", marker=".", markersize=3, label="where a segment is closest")
    touching = t_contact[contact == 1.0]
    if len(touching):
        axes.plot(touching, numpy.full(len(touching), 1e3 * facts["settings"]["contact_distance"]), linestyle="",
                  color="#D55E00", marker="X", label="contact")
    return begin[numpy.isnan(lower)]


def draw_curve(facts):
    figure, axes = plt.subplots(figsize=(6.2, 3.0), constrained_layout=True)
    unknown = (curve_of_states if facts["rows"] == "state" else curve_of_segments)(axes, facts)
    if len(unknown):
        axes.plot(unknown, numpy.zeros(len(unknown)), linestyle="", color="grey", marker="|", label="INVALID")
    lines = facts["settings"]["thresholds"] or {"contact": facts["settings"]["contact_distance"]}
    for name, style in (("warn", ":"), ("stop", "--"), ("contact", "-.")):
        if lines.get(name):
            axes.axhline(1e3 * lines[name], color="black", linewidth=0.8, linestyle=style, label=name + " distance")
    axes.axhline(0.0, color="black", linewidth=0.8)
    axes.set_ylabel("clearance [mm]")
    axes.legend(fontsize=7, ncol=3, loc="lower left", bbox_to_anchor=(0.0, 1.0), frameon=False)
    picture = svg_of(figure, "Clearance over the " + ("states" if facts["rows"] == "state" else "time"), "c")
    note = "<p>The lines are the thresholds of two links without thresholds of their own.</p>"
    return f'<div class="wide">{picture}</div>' + ("" if lines.get("are_equal", True) else note)


def draw_matrix(facts):
    known = {frozenset((pair["link_a"], pair["link_b"])): pair["distance"] for pair in facts["pairs"]}
    used = {name for pair in known for name in pair}
    names = [name for name in dict.fromkeys(row[0] for row in facts["collisions"]) if name in used]
    names += sorted(used.difference(names))
    size = len(names)
    font = min(8.0, 250.0 / size)
    values = numpy.full((size, size), numpy.nan)
    figure, axes = plt.subplots(figsize=(6.2, 5.6), constrained_layout=True)
    for row, column in zip(*numpy.tril_indices(size, -1)):
        distance = known.get(frozenset((names[row], names[column])))
        values[row, column] = numpy.nan if distance is None else 1e3 * distance
        words, color = "\N{MULTIPLICATION SIGN}", "#777777"
        if distance is not None:
            words = f"{1e3 * distance:.0f}" if size <= MOST_NUMBERS else "0" * (distance <= 0.0)
            color = "white" if distance < 0.5 * NEAR else "black"
        if words and size <= MOST_WORDS:
            axes.text(column + 0.5, row + 0.5, words, fontsize=0.9 * font, ha="center", va="center", color=color)
    image = axes.pcolormesh(numpy.ma.masked_invalid(values), cmap="cividis", vmin=0.0, vmax=1e3 * NEAR, edgecolors="white",
                            linewidth=0.3)
    places, labels = numpy.arange(size) + 0.5, [label(name) for name in names]
    axes.set_xticks(places)
    axes.set_yticks(places)
    axes.set_xticklabels(labels, fontsize=font, rotation=90)
    axes.set_yticklabels(labels, fontsize=font)
    axes.set_xlim(0, size - 1)
    axes.set_ylim(size, 1)
    figure.colorbar(image, ax=axes, label="smallest distance [mm]", extend="both", shrink=0.6)
    return svg_of(figure, "Smallest distance of each pair", "m")


def draw_views(pair, moment, number):
    """The two of a pair, seen along z, y and x."""
    every = []
    for view, (right, up) in enumerate(((0, 1), (0, 2), (1, 2))):
        figure, axes = plt.subplots(figsize=(2.9, 2.9), constrained_layout=True)
        sizes = []
        for pieces, color, style in zip(moment["shapes"], (BLUE, ORANGE), ("-", "--")):
            outlines = [numpy.array(piece[view], dtype=float) for piece in pieces]
            if not outlines:
                continue  # a half-space
            many = len(outlines) > MOST_OUTLINES
            axes.add_collection(PolyCollection(outlines, facecolor=to_rgba(color, 0.3), linewidth=0.7, linestyle=style,
                                               edgecolor=to_rgba(color, 0.1 if many else 0.9), rasterized=many))
            corners = numpy.vstack(outlines)
            sizes.append((corners.min(axis=0), corners.max(axis=0)))
        points = numpy.array([[pair[f"point_{end}_{'xyz'[axis]}"] for axis in (right, up)] for end in "ab"], dtype=float)
        window(axes, sizes, points)
        axes.plot(*points.T, color="black", linewidth=1.2)
        for point, marker in zip(points, "os"):
            axes.plot(*point, color="black", marker=marker, markersize=4, markerfacecolor="white")
        axes.set_xlabel("xyz"[right] + " [m]")
        axes.set_ylabel("xyz"[up] + " [m]")
        axes.tick_params(labelsize=7)
        axes.locator_params(nbins=5)
        every.append(svg_of(figure, f"{pair_name(pair)}, seen along {'zyx'[view]}", f"{number}-{view}"))
    return '<div class="views">' + "".join(every) + "</div>"


def window(axes, sizes, points):
    """Shows both shapes, but of one that is far larger only what is near the other one."""
    low, high = (numpy.array([limits[i] for limits in sizes]) for i in (0, 1))
    middle = numpy.nanmean(points, axis=0) if numpy.isfinite(points).any() else 0.5 * (low.min(axis=0) + high.max(axis=0))
    near = 2.0 * (high - low).max(axis=1).min() + numpy.nan_to_num(numpy.ptp(points, axis=0)).max()
    low, high = numpy.maximum(low.min(axis=0), middle - near), numpy.minimum(high.max(axis=0), middle + near)
    half = 0.55 * max(high - low)
    for limits, centre in zip((axes.set_xlim, axes.set_ylim), 0.5 * (low + high)):
        limits(centre - half, centre + half)
    axes.set_aspect("equal")


def first_words(facts):
    if not facts["moments"]:
        return "<p>No pair has an answer in any state.</p>"
    worst = facts["pairs"][0]
    closest = min((pair for pair in facts["pairs"] if pair["distance"] is not None), key=lambda pair: pair["distance"])
    words = ""
    for name, pair in [("Worst level", worst)] * (worst is not closest) + [("Closest", closest)]:
        words += f'<p class="key">{name}: <b>{text(pair_name(pair))}</b>, <b>{mm(pair["distance"])} mm</b>, ' \
                 f'{pair["level"] + ", " if "level" in pair else ""}{place(pair, facts)}.</p>'
    return words + f"<p>{text(facts.get('assertion', ''))}</p>"


def shares(facts):
    lower, level = array(facts, "lower"), array(facts, "level")
    is_states = facts["rows"] == "state"
    weights = numpy.ones(len(lower)) if is_states else array(facts, "end") - array(facts, "begin")
    whole = weights.sum()

    def row(name, chosen):
        part = weights[chosen].sum()
        return [name, f"{100.0 * part / whole:.2f} %" if whole else "", f"{part:.10g} of {whole:.10g}" + ("" if is_states else " s")]

    rows = [row(f"level {name}", level == number) for number, name in enumerate(LEVELS) if facts["settings"]["thresholds"]]
    if not numpy.isfinite(lower).all():
        rows.append(row("without an answer (INVALID)", ~numpy.isfinite(lower)))
    rows += [row(f"at {1e3 * gap:.0f} mm or below", lower <= gap) for gap in GAPS]
    note = "" if is_states else " Each segment has parts of 20 ms, at most 64. The whole time of a part counts if it " \
        "comes as close anywhere."
    return f"<p>The proven lower bound decides.{note}</p>" + table(["", "#share", "#"], rows)


def moments(facts):
    parts = ["<p>The closest state of each of the closest pairs. Coordinates are those of the root link.</p>"]
    for number, (pair, moment) in enumerate(zip(facts["pairs"], facts["moments"]), 1):
        level = f"; {pair['level']} (stop {mm(moment['stop'])} mm, warn {mm(moment['warn'])} mm)" if "level" in pair else ""
        deeper = "; the whole overlap may be deeper" if moment["depth_is_lower_bound"] else ""
        state = " ".join(f"{joint}={position!r}" for joint, position in moment["positions"].items())
        parts.append(
            f'<div class="moment"><h3>{number}. {text(pair_name(pair))}: {mm(pair["distance"])} mm</h3>'
            f'<p>{place(pair, facts).capitalize()}; between {mm(pair["lower"])} and '
            f'{mm(pair["upper"])} mm{deeper}; geometry {text(pair["representation"])}{level}.<br/>'
            f'<b>{text(pair["link_a"])}</b> blue, solid edge, round end of the line; <b>{text(pair["link_b"])}</b> orange, dashed '
            f'edge, square end.</p>{draw_views(pair, moment, number)}<p>State: {code(state)}</p></div>\n')
    return "".join(parts)


def pairs_table(facts):
    rows = []
    for pair in facts["pairs"]:
        where = "no answer" if pair["distance"] is None else place(pair, facts)
        rows.append([text(pair_name(pair)), mm(pair["distance"]), mm(pair["lowest"]), where, pair.get("level", "")])
    return table(["pair", "#smallest [mm]", "#proven [mm]", "first", ""], rows)


def unchecked(facts):
    groups = {}
    for link_a, link_b, reason, detail in facts["unchecked"]:
        pair = text(pair_name({"link_a": link_a, "link_b": link_b}))
        groups.setdefault(reason + (f" ({detail})" if detail else ""), []).append(pair)
    return "<dl>" + "".join(f"<dt>{text(reason)}: {len(pairs)}</dt><dd>{'; '.join(pairs)}</dd>\n"
                            for reason, pairs in sorted(groups.items())) + "</dl>"


def sentences(those):
    return "".join(f"<p>{text(sentence)}</p>" for sentence in those) or "<p>None.</p>"


def checked(facts):
    asked, settings = facts["asked"], facts["settings"]
    model, question = asked["model"], asked["question"]
    rows = [("robot", text(model["robot"]))]
    rows += [(name, code(words) + (f", hash {code(digest)}" if digest else "")) for name, words, digest in asked["files"]]
    states = "states" if facts["rows"] == "state" else "segments, with all that lies between their way points"
    rows += [
        ("version", f"{text(asked['program']['version'])}, program {code(asked['program']['digest'])}"),
        ("model as it was loaded", f"joints {code(model['joints'])}, shapes {code(model['shapes'])}, pairs and reasons "
         f"{code(model['pairs'])}"),
        ("states", text(asked["states"]["identity"] or "standard input") + f"; {len(array(facts, 'lower'))} {states}"),
        ("pairs", f"{len(facts['pairs'])} checked" + ("" if question["filter"] else ", without the filter")),
        ("tolerances", f"pieces {mm(asked['mesh_tolerance'])} mm from their meshes; distances {1e3 * asked['tolerance']:.1g} mm"),
        ("padding", f"links none, objects at most {mm(settings['padding_of_objects'])} mm"),
    ]
    for name, key in (("joint uncertainty", "is_uncertain"), ("tracking error", "has_tracking_error")):
        if not settings[key]:
            rows.append((name, "none: the states are taken to be exact"))
    if facts["rows"] == "segment":
        rows.append(("contact", f"{mm(settings['contact_distance'])} mm or below"))
    thresholds = settings["thresholds"]
    if thresholds:
        rows.append(("stop and warn distances", ", ".join(f"{key.replace('_', ' ')} {mm(value)} mm" for key, value in thresholds.items())
                     + f"; of single pairs {code(question['thresholds_of_pairs'])}"))
    if question["objects"]:
        rows.append(("shapes of the objects", code(question["object_shapes"])))
    return table(["", ""], rows)


def fidelity(facts):
    rows = [[text(link), f'<div class="mesh">{text(geometry)}</div>', text(representation), pieces, mm(deviation), mm(uncovered)]
            for link, geometry, representation, pieces, deviation, uncovered in facts["collisions"]]
    return "<p>How far the convex pieces lie outside of the mesh, and the mesh outside of the pieces.</p>" + table(
        ["link", "geometry", "as", "#pieces", "#outside of it [mm]", "#uncovered [mm]"], rows)


def command(facts):
    note = "" if facts["asked"]["states"]["identity"] else "<p>The states came from standard input, which is needed again.</p>"
    return f"<p>{code('rosrun proximity_server clearance ' + ' '.join(map(shlex.quote, facts['asked']['command'])))}</p>{note}"


def page(facts):
    title = "Clearance of " + text(facts["asked"]["model"]["robot"])
    over = "the states" if facts["rows"] == "state" else "the time"
    parts = [
        (f"Share of {over}", shares(facts)), ("Pairs never checked", unchecked(facts)),
        ("States beyond limits", sentences(facts["excess"])), ("What was checked", checked(facts)),
        ("Geometry", fidelity(facts)), ("Warnings about the model", sentences(facts["warnings"])),
        ("The command", command(facts))]
    if facts["moments"]:
        parts.insert(1, ("Worst moments", moments(facts)))
        parts.insert(2, ("All pairs", "<p>\N{MULTIPLICATION SIGN}: never checked. 0: contact.</p>"
                         f'<div class="wide">{draw_matrix(facts)}</div>{pairs_table(facts)}'))
        parts.insert(0, (f"Clearance over {over}", draw_curve(facts)))
    body = "".join(f"<h2>{head}</h2>\n{content}\n" for head, content in parts)
    return ('<!DOCTYPE html>\n<html xmlns="http://www.w3.org/1999/xhtml" lang="en"><head><meta charset="utf-8"/>'
            '<meta name="viewport" content="width=device-width, initial-scale=1"/>'
            f"<title>{title}</title><style>{STYLE}</style></head>\n<body><h1>{title}</h1>\n{first_words(facts)}\n{body}"
            "</body></html>\n")


if __name__ == "__main__" and len(sys.argv) == 3:
    matplotlib.rcParams.update({"svg.hashsalt": "clearance", "svg.fonttype": "none", "font.size": 8})
    warnings.filterwarnings("ignore", message="Glyph")  # the browser has other fonts
    with open(sys.argv[1], encoding="utf-8") as data:
        made = page(json.load(data))
    try:
        sys.stdout.buffer.write(made.encode())
        sys.stdout.flush()
    except OSError as error:
        sys.exit(str(error))
