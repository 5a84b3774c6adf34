#!/usr/bin/env python3
"""Writes the meshes of the demo robot: convex and concave, one and two components, in every format that URDFs use."""

import math
import pathlib
import struct

FOLDER = pathlib.Path(__file__).parent / "meshes"


def loft(rings):
    """Closed surface through rings of equally many points, each counter-clockwise about the direction of the rings."""
    n = len(rings[0])
    points = [point for ring in rings for point in ring]
    quads = [(r + i, r + (i + 1) % n, r + n + (i + 1) % n, r + n + i) for r in range(0, n * (len(rings) - 1), n) for i in range(n)]
    last = len(points) - n
    caps = [(0, i + 1, i) for i in range(1, n - 1)] + [(last, last + i, last + i + 1) for i in range(1, n - 1)]
    return points, [t for a, b, c, d in quads for t in ((a, b, c), (a, c, d))] + caps


def superellipse(half_x, half_y, z, sides):
    def corner(t):
        c, s = math.cos(t), math.sin(t)
        return (half_x * math.copysign(abs(c) ** 0.6, c), half_y * math.copysign(abs(s) ** 0.6, s), z)
    return [corner(2 * math.pi * i / sides) for i in range(sides)]


def chest():
    """Narrow waist, wide shoulders: not convex."""
    profile = [(0.115, 0.13, 0.0), (0.10, 0.11, 0.10), (0.125, 0.165, 0.24), (0.125, 0.185, 0.36), (0.10, 0.15, 0.43), (0.06, 0.08, 0.46)]
    return loft([superellipse(x, y, z, 32) for x, y, z in profile])


def drum(radius, half_width, chamfer, sides):
    """Chamfered prism about y: convex."""
    profile = [(-half_width, radius - chamfer), (chamfer - half_width, radius), (half_width - chamfer, radius),
               (half_width, radius - chamfer)]
    angles = [2 * math.pi * (i + 0.5) / sides for i in range(sides)]
    return loft([[(r * math.sin(t), y, r * math.cos(t)) for t in angles] for y, r in profile])


def fork():
    """Palm, two fingers and a thumb, as filled cells of a grid that tapers towards the tips: not convex."""
    xs = (0.0, 0.03, 0.05, 0.075, 0.15)
    ys = (-0.055, -0.045, -0.022, 0.022, 0.045)
    filled = {(0, 1), (0, 2), (0, 3), (1, 1), (1, 2), (1, 3), (1, 0), (2, 0), (2, 1), (2, 3), (3, 1), (3, 3)}
    index, points, triangles = {}, [], []

    def vertex(i, j, side):
        if (i, j, side) not in index:
            index[i, j, side] = len(points)
            points.append((xs[i], ys[j], side * (0.026 - 0.1 * xs[i])))
        return index[i, j, side]

    def quad(a, b, c, d):
        triangles.extend([(a, b, c), (a, c, d)])

    for i, j in sorted(filled):
        corners = [(i, j), (i + 1, j), (i + 1, j + 1), (i, j + 1)]
        quad(*[vertex(*corner, 1) for corner in corners])
        quad(*[vertex(*corner, -1) for corner in reversed(corners)])
        neighbours = [(i, j - 1), (i + 1, j), (i, j + 1), (i - 1, j)]
        for k, neighbour in enumerate(neighbours):
            if neighbour not in filled:
                start, end = corners[k], corners[(k + 1) % 4]
                quad(vertex(*start, -1), vertex(*end, -1), vertex(*end, 1), vertex(*start, 1))
    return points, triangles


def bumpers():
    """Two separate arcs, front and rear."""
    points, triangles = [], []
    for middle in (0.0, math.pi):
        angles = [middle + math.radians(a) for a in range(-60, 61, 10)]
        section = [(0.275, 0.0), (0.275, 0.05), (0.30, 0.05), (0.30, 0.0)]
        arc, faces = loft([[(r * math.cos(t), r * math.sin(t), z) for r, z in section] for t in angles])
        triangles += [tuple(i + len(points) for i in face) for face in faces]
        points += arc
    return points, triangles


def normal(points, triangle):
    a, b, c = (points[i] for i in triangle)
    u, v = [q - p for p, q in zip(a, b)], [q - p for p, q in zip(a, c)]
    n = (u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0])
    return [x / math.hypot(*n) for x in n]


def write_binary_stl(name, points, triangles):
    facets = [struct.pack("<12fH", *normal(points, t), *(x for i in t for x in points[i]), 0) for t in triangles]
    (FOLDER / name).write_bytes(b"proximity_server demo".ljust(80) + struct.pack("<I", len(triangles)) + b"".join(facets))


def write_ascii_stl(name, points, triangles):
    lines = [f"solid {name}"]
    for t in triangles:
        lines += ["facet normal %.6g %.6g %.6g" % tuple(normal(points, t)), "outer loop"]
        lines += ["vertex %.6g %.6g %.6g" % tuple(points[i]) for i in t] + ["endloop", "endfacet"]
    (FOLDER / name).write_text("\n".join(lines + [f"endsolid {name}", ""]))


def write_obj(name, points, triangles):
    lines = ["v %.6g %.6g %.6g" % point for point in points] + ["f %d %d %d" % tuple(i + 1 for i in t) for t in triangles]
    (FOLDER / name).write_text("\n".join(lines) + "\n")


def write_dae(name, points, triangles, offset):
    """The vertices are stored moved by -offset, and the node's transform moves them back."""
    floats = " ".join("%.6g" % (x - o) for point in points for x, o in zip(point, offset))
    (FOLDER / name).write_text(f"""<?xml version="1.0" encoding="utf-8"?>
<COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1">
  <asset><unit name="meter" meter="1"/><up_axis>Z_UP</up_axis></asset>
  <library_geometries>
    <geometry id="mesh"><mesh>
      <source id="points">
        <float_array id="points-array" count="{3 * len(points)}">{floats}</float_array>
        <technique_common><accessor source="#points-array" count="{len(points)}" stride="3">
          <param name="X" type="float"/><param name="Y" type="float"/><param name="Z" type="float"/>
        </accessor></technique_common>
      </source>
      <vertices id="vertices"><input semantic="POSITION" source="#points"/></vertices>
      <triangles count="{len(triangles)}"><input semantic="VERTEX" source="#vertices" offset="0"/>
        <p>{" ".join(str(i) for t in triangles for i in t)}</p>
      </triangles>
    </mesh></geometry>
  </library_geometries>
  <library_visual_scenes><visual_scene id="scene">
    <node id="node">
      <translate>{"%g %g %g" % offset}</translate>
      <instance_geometry url="#mesh"/>
    </node>
  </visual_scene></library_visual_scenes>
  <scene><instance_visual_scene url="#scene"/></scene>
</COLLADA>
""")


write_binary_stl("chest.stl", *chest())
write_ascii_stl("elbow.stl", *drum(radius=0.058, half_width=0.06, chamfer=0.014, sides=16))
write_obj("wrist.obj", *drum(radius=0.044, half_width=0.045, chamfer=0.012, sides=12))
write_obj("bumpers.obj", *bumpers())
write_dae("hand.dae", *fork(), offset=(0.05, 0.0, 0.0))
