#!/usr/bin/python3
"""explain_plot.py DATA.json FORMAT: what `explain` found as a picture (png, pdf or svg) on standard output; without
arguments: whether it can.

The first panel has the two shapes in the frame of a. One panel follows for each step: the CSO, the origin, the simplex of
GJK or the polytope of EPA. The last panel has the bounds. Where CSO and origin lie in one plane, the panels show that
plane."""
import json
import sys

try:
    import matplotlib
    matplotlib.use("Agg")
    import matplotlib.pyplot as plt
    import numpy
    from matplotlib.lines import Line2D
    from matplotlib.patches import Patch
    from matplotlib.patheffects import withStroke
    from mpl_toolkits.mplot3d import proj3d
    from mpl_toolkits.mplot3d.art3d import Line3DCollection, Poly3DCollection
    from PIL import Image
except ImportError as error:
    sys.exit(str(error))

MOST_PANELS = 6  # of GJK, and of EPA; of more steps the first, the last, and some in between are shown
PANEL = 3.1  # [inch]
CSO, NEW, SIMPLEX, NEAREST, FACE = "#7f9fbf", "#d62728", "#e08214", "#1a7f37", "#d62728"
SHAPES = {"a": "#5b3f8f", "b": "#b8860b"}
HALO = [withStroke(linewidth=2.5, foreground="white")]
ROUNDING = 1e-12  # [m] is written as 0
FEW_EDGES = 80
SHARP = 1.0 - 1e-9  # cosine between the normals of two triangles of one face


def number(value):
    return f"{0.0 if abs(value) < ROUNDING else value:.4g}".replace("-", "\N{MINUS SIGN}")


def shown(steps):
    """(number, step) of the steps that get a panel."""
    numbers = numpy.unique(numpy.linspace(0, len(steps) - 1, min(len(steps), MOST_PANELS)).round().astype(int))
    return [(int(i) + 1, steps[i]) for i in numbers] if steps else []


class Names:
    """The names of vertices, written last: beside each vertex, outwards, and not over each other."""

    FAR = 11.0  # [points] from the vertex to the middle of a letter
    LETTER = numpy.array([6.4, 11.0])  # [points] that a letter takes
    TURNS = numpy.radians([0, 35, -35, 70, -70, 105, -105, 140, -140, 180])

    def __init__(self):
        self.wanted = []

    def add(self, axes, name, place, outwards, color):
        self.wanted.append((axes, name, place, outwards, color))

    def write(self, points_per_pixel):
        """The panels must have their final places."""
        written = {}
        for axes, name, place, outwards, color in self.wanted:
            others = written.setdefault(axes, [])
            at = axes.transData.transform(place) * points_per_pixel
            half = 0.5 * self.LETTER * [len(name), 1.0]
            shift = self.shift(at, half, outwards, others)
            others.append((at + shift, half))
            axes.annotate(name, place, xytext=shift, textcoords="offset points", ha="center", va="center", color=color,
                          fontsize=9, fontweight="bold", path_effects=HALO, zorder=20, annotation_clip=False)

    def shift(self, at, half, outwards, others):
        """From the vertex `at` to the middle of its name: outwards, or turned as little as leaves room beside others."""
        along = outwards / numpy.linalg.norm(outwards) if numpy.any(outwards) else numpy.array([0.0, 1.0])
        shifts, rooms = [], []
        for turn in self.TURNS:
            turned = numpy.array([[numpy.cos(turn), -numpy.sin(turn)], [numpy.sin(turn), numpy.cos(turn)]]) @ along
            shifts.append(self.FAR * turned + [turned[0] * (half[0] - 0.5 * self.LETTER[0]), 0.0])
            gaps = [(numpy.abs(at + shifts[-1] - other) - half - other_half).max() for other, other_half in others]
            rooms.append(min(gaps, default=1.0))
        return next((shift for shift, room in zip(shifts, rooms) if room > 0.0), shifts[int(numpy.argmax(rooms))])


def outline(points):
    """Indices of the corners of the convex hull of points in the plane, in their order (Andrew's chains)."""
    order = sorted(range(len(points)), key=lambda i: tuple(points[i]))

    def chain(indices):
        corners = []
        for i in indices:
            while len(corners) > 1:
                (ax, ay), (bx, by) = points[corners[-1]] - points[corners[-2]], points[i] - points[corners[-2]]
                if ax * by - ay * bx > 0.0:
                    break
                corners.pop()
            corners.append(i)
        return corners[:-1]

    return chain(order) + chain(order[::-1])


def bounds_text(step):
    low, high = (number(step[name]) if step[name] is not None else "?" for name in ("lower", "upper"))
    return f"{low} … {high} m"


def closest_points(data):
    """Those of a and b; none if the answer has no points."""
    return numpy.array([point for point in (data["point_a"], data["point_b"]) if None not in point]).reshape(-1, 3)


class Plane:
    """Draws in the plane of a flat CSO: in x and y where it is parallel to them."""

    projection = None

    def __init__(self, data):
        self.data, self.names = data, Names()
        points = numpy.array(data["cso"]["points"])
        self.axes = self.axes_of(points)
        self.corners = points @ self.axes.T
        self.vertices = [numpy.array(vertex["point"]) @ self.axes.T for vertex in data["vertices"]]
        self.every = numpy.vstack([self.corners, numpy.zeros((1, 2))] + self.vertices)
        self.size = numpy.ptp(self.every, axis=0).max()
        self.inside = self.corners.mean(axis=0)

    @staticmethod
    def axes_of(points):
        """Two unit vectors along the plane of the points and the origin."""
        if not numpy.any(points[:, 2]):
            return numpy.eye(3)[:2]
        return numpy.linalg.svd(points)[2][:2]

    @staticmethod
    def look_at(axes, points):
        low, high = points.min(axis=0), points.max(axis=0)
        margin = 0.12 * max(high - low)
        axes.set_xlim(low[0] - margin, high[0] + margin)
        axes.set_ylim(low[1] - margin, high[1] + margin)
        axes.set_aspect("equal")
        axes.tick_params(labelsize=7, color="#aaaaaa")
        for spine in axes.spines.values():
            spine.set_color("#cccccc")

    @staticmethod
    def body(axes, corners, color):
        axes.fill(*corners.T, facecolor=color, alpha=0.18, edgecolor="none")
        axes.plot(*numpy.vstack([corners, corners[:1]]).T, color=color, linewidth=1.0)
        axes.plot(*corners.T, color=color, marker=".", markersize=4, linestyle="")

    def shapes(self, axes, _):
        bodies = [numpy.array(shape["points"]) @ self.axes.T for shape in self.data["shapes"]]
        self.look_at(axes, numpy.vstack(bodies))
        for corners, color in zip(bodies, SHAPES.values()):
            self.body(axes, corners[outline(corners)] if len(corners) > 1 else corners, color)
        points = closest_points(self.data) @ self.axes.T
        axes.plot(*points.T, color=NEAREST, marker="o", markersize=5, linewidth=1.4, zorder=5)

    def prepare(self, axes):
        self.look_at(axes, self.every)
        self.body(axes, self.corners, CSO)
        axes.plot(0, 0, color="black", marker="+", markersize=10, markeredgewidth=1.4, zorder=6)

    def label(self, axes, vertex, color):
        place = self.vertices[vertex]
        self.names.add(axes, self.data["vertices"][vertex]["name"], place, place - self.inside, color)

    def gjk(self, axes, step):
        self.prepare(axes)
        direction = numpy.array(step["direction"]) @ self.axes.T
        new = self.vertices[step["vertex"]]
        across = numpy.array([-direction[1], direction[0]])
        axes.plot(*numpy.array([new - 3 * self.size * across, new + 3 * self.size * across]).T, color=NEW,
                  linewidth=0.9, linestyle=(0, (4, 3)))
        corners = numpy.array([self.vertices[v] for v in step["simplex"]])
        if len(corners) == 3:
            axes.fill(*corners.T, facecolor=SIMPLEX, alpha=0.25, edgecolor="none")
        if len(corners) > 1:
            axes.plot(*numpy.vstack([corners, corners[:1]]).T, color=SIMPLEX, linewidth=2.2, zorder=4)
        nearest = numpy.array(step["nearest"], dtype=float) @ self.axes.T
        axes.plot(*numpy.array([[0, 0], nearest]).T, color=NEAREST, linewidth=1.4, zorder=5)
        axes.plot(*nearest, color=NEAREST, marker="o", markersize=5, zorder=7)
        for vertex in step["simplex"]:
            axes.plot(*self.vertices[vertex], color=SIMPLEX, marker="o", markersize=5, zorder=6)
        axes.plot(*new, color=NEW, marker="o", markersize=5, zorder=7)
        for vertex in {step["vertex"], *step["simplex"]}:
            self.label(axes, vertex, NEW if vertex == step["vertex"] else SIMPLEX)
        self.name_others(axes, {step["vertex"], *step["simplex"]})

    def name_others(self, axes, named):
        """The points of a, where they are known by name and do not belong to the step."""
        names = {self.data["vertices"][vertex]["name"] for vertex in named}
        for other in self.data["cso"]["named"]:
            if other["name"] not in names:
                place = numpy.array(other["point"]) @ self.axes.T
                axes.plot(*place, color=CSO, marker=".", markersize=4)
                self.names.add(axes, other["name"], place, place - self.inside, CSO)

    def answer(self, axes):
        self.prepare(axes)
        self.name_others(axes, set())


class Body:
    """A body in space, as its hull."""

    def __init__(self, data):
        self.corners = numpy.array(data["points"])
        self.is_solid = bool(data["triangles"])
        self.edges = self.sharp_edges(data["triangles"]) if data["is_polytope"] else []  # a round body has none

    def sharp_edges(self, triangles):
        """Without the diagonals of the faces."""
        normals = {}
        for triangle in triangles:
            a, b, c = self.corners[triangle]
            normal = numpy.cross(b - a, c - a)
            normal /= max(numpy.linalg.norm(normal), 1e-300)
            for i in range(3):
                edge = frozenset((triangle[i], triangle[(i + 1) % 3]))
                normals.setdefault(edge, []).append(normal)
        return [self.corners[list(edge)] for edge, of in normals.items() if len(of) < 2 or of[0] @ of[1] < SHARP]


class Space:
    """Draws in space, seen from beside the normal of the answer."""

    projection = "3d"

    def __init__(self, data):
        self.data, self.names = data, Names()
        self.cso, self.bodies = Body(data["cso"]), [Body(shape) for shape in data["shapes"]]
        self.vertices = [numpy.array(vertex["point"]) for vertex in data["vertices"]]
        self.inside = self.cso.corners.mean(axis=0)
        normal = [value or 0.0 for value in data["normal"]]
        self.azimuth = numpy.degrees(numpy.arctan2(normal[1], normal[0])) + 55.0

    def look_at(self, axes, points):
        low, high = points.min(axis=0), points.max(axis=0)
        middle, half = 0.5 * (low + high), 0.5 * max(high - low) or 1.0
        axes.set_proj_type("ortho")
        axes.view_init(elev=18.0, azim=self.azimuth)
        axes.set_axis_off()
        for limits, centre in zip((axes.set_xlim, axes.set_ylim, axes.set_zlim), middle):
            limits(centre - half, centre + half)
        axes.set_box_aspect((1, 1, 1), zoom=self.zoom(axes, numpy.vstack([points, middle])))
        axes.computed_zorder = False  # what belongs to the step lies over the CSO

    def body(self, axes, body, color):
        if not body.is_solid:
            axes.plot(*body.corners.T, color=color, marker=".", linewidth=1.5)
            return
        around = body.corners[outline(self.seen(axes, body.corners))]
        axes.add_collection3d(Poly3DCollection([around], facecolor=color, edgecolor=color, linewidth=1.0, alpha=0.18, zorder=1))
        if body.edges:
            axes.add_collection3d(Line3DCollection(body.edges, colors=color, zorder=2,
                                                   linewidths=0.7 if len(body.edges) < FEW_EDGES else 0.2))

    def shapes(self, axes, _):
        self.look_at(axes, numpy.vstack([body.corners for body in self.bodies]))
        for body, color in zip(self.bodies, SHAPES.values()):
            self.body(axes, body, color)
        axes.plot(*closest_points(self.data).T, color=NEAREST, marker="o", markersize=5, linewidth=1.6, zorder=9)

    def prepare(self, axes):
        self.look_at(axes, numpy.vstack([self.cso.corners, numpy.zeros((1, 3))]))
        self.body(axes, self.cso, CSO)
        axes.plot([0], [0], [0], color="black", marker="+", markersize=10, markeredgewidth=1.4, zorder=10)

    def zoom(self, axes, points):
        """So that the points fill the height of the panel, or more than its square in width. The last one is its middle."""
        axes.set_box_aspect((1, 1, 1))
        places = self.seen(axes, points)
        reach = numpy.abs(places - places[-1]).max(axis=0)
        if not reach.any():
            return 1.0  # one point
        return 0.5 * min(axes.viewLim.width * 1.15 / max(reach[0], 1e-300), axes.viewLim.height * 0.9 / max(reach[1], 1e-300))

    @staticmethod
    def seen(axes, points):
        """Where the panel shows points of space."""
        return numpy.column_stack(proj3d.proj_transform(*numpy.transpose(points), axes.get_proj())[:2])

    def label(self, axes, vertex, color):
        place, inside = self.seen(axes, [self.vertices[vertex], self.inside])
        self.names.add(axes, self.data["vertices"][vertex]["name"], place, place - inside, color)

    def point(self, axes, point, color):
        axes.plot(*numpy.reshape(point, (3, 1)), color=color, marker="o", markersize=5, zorder=9)

    def segment(self, axes, begin, end, color, style="-"):
        axes.plot(*numpy.array([begin, end]).T, color=color, linewidth=1.6, linestyle=style, zorder=8)

    def gjk(self, axes, step):
        self.prepare(axes)
        corners = [self.vertices[v] for v in step["simplex"]]
        for i, a in enumerate(corners):
            for j, b in enumerate(corners[:i]):
                self.segment(axes, a, b, SIMPLEX)
                for c in corners[:j]:
                    axes.add_collection3d(Poly3DCollection([[a, b, c]], facecolor=SIMPLEX, alpha=0.18, zorder=3))
        nearest = numpy.array(step["nearest"], dtype=float)
        self.segment(axes, numpy.zeros(3), nearest, NEAREST)
        for vertex in step["simplex"]:
            self.point(axes, self.vertices[vertex], SIMPLEX)
        self.point(axes, nearest, NEAREST)
        self.point(axes, self.vertices[step["vertex"]], NEW)
        for vertex in {step["vertex"], *step["simplex"]}:
            self.label(axes, vertex, NEW if vertex == step["vertex"] else SIMPLEX)

    def epa(self, axes, step):
        self.prepare(axes)
        faces = [[self.vertices[v] for v in face] for face in step["faces"]]
        axes.add_collection3d(Poly3DCollection(faces, facecolor=SIMPLEX, edgecolor=SIMPLEX, linewidth=0.9, alpha=0.14,
                                               zorder=3))
        closest = numpy.array([self.vertices[v] for v in step["closest"]])
        axes.add_collection3d(Poly3DCollection([closest], facecolor=FACE, edgecolor=FACE, linewidth=1.6, alpha=0.38,
                                               zorder=4))
        normal = numpy.array(step["normal"])
        foot = normal * (closest @ normal).min()
        self.segment(axes, numpy.zeros(3), foot, NEAREST)
        self.point(axes, foot, NEAREST)
        new = self.vertices[step["vertex"]]
        if step["vertex"] not in step["closest"]:
            self.segment(axes, foot, foot + normal * (normal @ new - normal @ foot), NEW, ":")
        self.point(axes, new, NEW)
        for vertex in {step["vertex"], *step["closest"]}:
            self.label(axes, vertex, NEW)

    def answer(self, axes):
        """What a closed form answers: the point of the CSO's surface along the normal, if the answer has points."""
        self.prepare(axes)
        if None in self.data["point_a"] or self.data["distance"] is None:
            return
        point = -(self.data["distance"] + self.data["margins"]) * numpy.array(self.data["normal"])
        self.segment(axes, numpy.zeros(3), point, NEAREST)
        self.point(axes, point, NEAREST)


def draw_bounds(axes, data):
    steps = data["gjk"] + data["epa"]
    last = len(steps) + 1
    for name, color, marker in (("upper", "#1f4e79", "v"), ("lower", "#7a3b8f", "^")):
        values = [(i, step[name]) for i, step in enumerate(steps, 1) if step[name] is not None]
        if data[name] is not None:
            values.append((last, data[name]))
        axes.plot(*numpy.array(values, dtype=float).reshape(-1, 2).T, color=color, marker=marker, markersize=4, linewidth=1.2,
                  label=name)
    if data["distance"] is not None:
        axes.axhline(data["distance"], color="#999999", linewidth=0.8, zorder=0)
    if data["gjk"] and data["epa"]:
        axes.axvline(len(data["gjk"]) + 0.5, color="#999999", linewidth=0.8, linestyle=":")
    stride = -(-len(steps) // 10) or 1
    ticks = list(range(1, len(steps) + 1, stride))
    names = [str(i) if i <= len(data["gjk"]) else str(i - len(data["gjk"])) for i in ticks]
    axes.set_xticks(ticks + [last])
    axes.set_xticklabels(names + ["end"])
    axes.tick_params(labelsize=7, color="#aaaaaa")
    for spine in axes.spines.values():
        spine.set_color("#cccccc")
    axes.set_xlabel("step of GJK | step of EPA" if data["epa"] and data["gjk"] else "step", fontsize=8)
    axes.set_title("bounds of the distance [m]", fontsize=9)
    axes.legend(fontsize=7, frameon=False)


def draw(data):
    cso = data["cso"]
    is_flat = cso["dimension"] == 2 and cso["dimension_with_origin"] == 2 and not data["epa"]
    view = Plane(data) if is_flat else Space(data)
    panels = [(f"GJK {i}: {bounds_text(step)}", view.gjk, step) for i, step in shown(data["gjk"])]
    panels += [(f"EPA {i}: {bounds_text(step)}", view.epa, step) for i, step in shown(data["epa"])]
    if not panels:
        panels = [("the CSO and the origin", lambda axes, _: view.answer(axes), None)]
    panels.insert(0, ("a and b", view.shapes, None))
    count = len(panels) + (1 if data["gjk"] else 0)
    columns = 1 if count == 1 else 2 if count <= 4 else 3 if count <= 6 else 4
    rows = -(-count // columns)
    width, height = max(PANEL * columns, 5.5), PANEL * (1.0 if view.projection is None else 0.85) * rows + 0.8
    figure = plt.figure(figsize=(width, height), dpi=100)
    grid = figure.add_gridspec(rows, columns)
    distance = "" if data["distance"] is None else f"signed distance {number(data['distance'])} m, "
    heading = f"{distance}by {data['by']}".replace(", by", "\nby" if len(data["by"]) > 40 else ", by")
    figure.suptitle(heading, fontsize=10).set_in_layout(False)  # its room is in the rect below
    for place, (title, paint, step) in enumerate(panels):
        axes = figure.add_subplot(grid[place // columns, place % columns], projection=view.projection)
        paint(axes, step)
        axes.set_title(title, fontsize=9, pad=12 if view.projection else 6)
        if view.projection:
            for artist in axes.lines + axes.collections:  # they may reach beyond the square of the panel
                artist.set_clip_on(False)
                artist.set_in_layout(False)
    if data["gjk"]:
        free = len(panels) % columns
        draw_bounds(figure.add_subplot(grid[rows - 1, free:min(free + 2, columns)]), data)
    figure.legend(handles=keys(data, view), loc="lower center", ncol=8, fontsize=8, frameon=False)
    figure.tight_layout(rect=(0, 0.3 / height, 1, 1 - (0.2 + 0.15 * len(heading.splitlines())) / height))
    figure.canvas.draw()
    view.names.write(72.0 / figure.dpi)
    return figure


def keys(data, view):
    """What the colours of the panels are."""
    cso = "CSO" if data["margins"] == 0.0 else f"CSO of the cores (margins {number(data['margins'])} m)"
    support = "--" if view.projection is None else ""
    handles = [Patch(facecolor=color, alpha=0.4, label=name) for name, color in SHAPES.items()]
    handles += [Line2D([], [], color="black", marker="+", markersize=9, markeredgewidth=1.4, linestyle="", label="origin"),
                Patch(facecolor=CSO, alpha=0.4, label=cso)]
    if data["gjk"]:
        handles += [Line2D([], [], color=SIMPLEX, marker="o", markersize=5, linewidth=2.2,
                           label="simplex, polytope" if data["epa"] else "simplex"),
                    Line2D([], [], color=NEW, marker="o", markersize=5, linewidth=0.9, linestyle=support,
                           label="new vertex, support plane" if support else "new vertex")]
    handles.append(Line2D([], [], color=NEAREST, marker="o", markersize=5, label="nearest point"))
    if data["epa"]:
        handles.append(Patch(facecolor=FACE, alpha=0.5, label="closest face"))
    return handles


def save(figure, picture_format):
    """A PNG has 256 colours, which are enough, and a third of the size."""
    if picture_format != "png":
        figure.savefig(sys.stdout.buffer, format=picture_format)
        return
    figure.canvas.draw()
    Image.fromarray(numpy.asarray(figure.canvas.buffer_rgba())[..., :3].copy()).quantize(
        256, dither=0).save(sys.stdout.buffer, format="png", optimize=True)


if __name__ == "__main__":
    if len(sys.argv) == 3:
        source, picture_format = sys.argv[1:]
        with open(source, encoding="utf-8") as stream:
            found = json.load(stream)
        try:
            save(draw(found), picture_format)
            sys.stdout.flush()
        except OSError as error:
            sys.exit(str(error))
