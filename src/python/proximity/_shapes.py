"""The shapes of objects. Lengths are in metres; each shape is in its own frame."""

import dataclasses
import os
from typing import Any, Sequence, Union


@dataclasses.dataclass(frozen=True)
class Sphere:
    """A ball around the origin."""

    radius: float


@dataclasses.dataclass(frozen=True)
class Capsule:
    """A cylinder along z with a half ball at both ends; `length` is that between the centres of the balls."""

    radius: float
    length: float


@dataclasses.dataclass(frozen=True)
class Box:
    """A box around the origin; `size` has its three edges."""

    size: Sequence[float]


@dataclasses.dataclass(frozen=True)
class Cylinder:
    """A cylinder along z around the origin."""

    radius: float
    length: float


@dataclasses.dataclass(frozen=True)
class Cone:
    """A cone along z: its base is at -length / 2, its tip at length / 2."""

    radius: float
    length: float


@dataclasses.dataclass(frozen=True)
class Ellipsoid:
    """An ellipsoid around the origin, with a radius along each axis."""

    radii: Sequence[float]


@dataclasses.dataclass(frozen=True)
class HalfSpace:
    """All points x with normal . x <= offset, for a `normal` of length 1: the floor is HalfSpace((0, 0, 1))."""

    normal: Sequence[float]
    offset: float = 0.0


@dataclasses.dataclass(frozen=True, eq=False)
class Boxes:
    """Many boxes along the axes, as from a map: their lowest and highest corners, both of shape (boxes, 3)."""

    lower: Any
    upper: Any


@dataclasses.dataclass(frozen=True, eq=False)
class Mesh:
    """A mesh of triangles: `vertices` of shape (vertices, 3), and `triangles`, whole numbers of shape
    (triangles, 3)."""

    vertices: Any
    triangles: Any


@dataclasses.dataclass(frozen=True)
class MeshFile:
    """A mesh that is read from a file (.stl, .dae, .obj, .ply): a path, or a URI with package:// or file://."""

    path: Union[str, os.PathLike]
    scale: Sequence[float] = (1.0, 1.0, 1.0)


@dataclasses.dataclass(frozen=True, eq=False)
class Object:
    """An object of a robot, as Robot.objects has it. The fields are the arguments of Robot.with_object()."""

    shapes: Any
    pose: Any = None
    link: str = ""
    touch_links: Sequence[str] = ()
    frame: str = ""
    padding: float = 0.0
