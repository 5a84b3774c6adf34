"""Types of the compiled part. Its docstrings are in the module itself: help(proximity.Robot)."""

import math
import os
from typing import Any, Optional, Sequence, Union

import numpy
import numpy.typing

from proximity._shapes import Object

_Path = Union[str, os.PathLike[str]]
_PairOfArrays = Union[tuple[numpy.typing.ArrayLike, numpy.typing.ArrayLike], Sequence[numpy.typing.ArrayLike], numpy.typing.NDArray[Any]]

__version__: str
CONTACT: numpy.dtype[numpy.void]
EDGE_MINIMUM: numpy.dtype[numpy.void]
HIT: numpy.dtype[numpy.void]
LEVELED_PAIR: numpy.dtype[numpy.void]
PAIR: numpy.dtype[numpy.void]
POINT: numpy.dtype[numpy.void]
PROOF: numpy.dtype[numpy.void]
VERDICT: numpy.dtype[numpy.void]

class Joint:
    @property
    def name(self) -> str: ...
    @property
    def type(self) -> str: ...
    @property
    def lower(self) -> float: ...
    @property
    def upper(self) -> float: ...
    @property
    def mimic(self) -> Optional[str]: ...

class Robot:
    def __init__(
        self,
        urdf: _Path,
        srdf: Optional[_Path] = None,
        *,
        mesh_tolerance: Optional[float] = None,
        packages: Optional[Sequence[_Path]] = None,
        padding: Optional[float] = None,
        group: str = "",
        exclude_pairs: Sequence[tuple[str, str]] = [],
        only_pairs: Sequence[tuple[str, str]] = [],
        thresholds: Optional[_Path] = None,
        config: Optional[_Path] = None,
        allow_missing_meshes: bool = False,
        allow_broken_mimics: bool = False,
        threads: Optional[int] = None,
    ) -> None: ...
    @staticmethod
    def from_text(
        urdf: str,
        srdf: str = "",
        *,
        folder: _Path = ".",
        mesh_tolerance: Optional[float] = None,
        packages: Optional[Sequence[_Path]] = None,
        padding: Optional[float] = None,
        group: str = "",
        exclude_pairs: Sequence[tuple[str, str]] = [],
        only_pairs: Sequence[tuple[str, str]] = [],
        thresholds: str = "",
        config: str = "",
        allow_missing_meshes: bool = False,
        allow_broken_mimics: bool = False,
        threads: Optional[int] = None,
    ) -> Robot: ...
    @property
    def name(self) -> str: ...
    @property
    def joints(self) -> list[Joint]: ...
    @property
    def ranges(self) -> numpy.typing.NDArray[numpy.float64]: ...
    @property
    def pairs(self) -> list[tuple[str, str]]: ...
    @property
    def links(self) -> list[str]: ...
    @property
    def objects(self) -> dict[str, Object]: ...
    @property
    def unchecked(self) -> list[tuple[str, str, str]]: ...
    @property
    def warnings(self) -> list[str]: ...
    @property
    def threads(self) -> int: ...
    @threads.setter
    def threads(self, threads: int) -> None: ...
    # `shapes` is a shape of proximity._shapes, or a list of shapes and of pairs (shape, pose).
    def with_object(
        self,
        name: str,
        shapes: Any,
        pose: Optional[numpy.typing.ArrayLike] = None,
        *,
        link: str = "",
        touch_links: Sequence[str] = [],
        frame: str = "",
        padding: float = 0.0,
    ) -> Robot: ...
    def with_objects(self, file: _Path) -> Robot: ...
    def with_points(self, points: numpy.typing.ArrayLike, resolution: float = 0.02, name: str = "points") -> Robot: ...
    def moved(self, name: str, pose: Optional[numpy.typing.ArrayLike], *, frame: str = "") -> Robot: ...
    def attached(
        self,
        name: str,
        link: str,
        pose: Optional[numpy.typing.ArrayLike] = None,
        *,
        q: Optional[numpy.typing.ArrayLike] = None,
        touch_links: Sequence[str] = [],
    ) -> Robot: ...
    def detached(
        self,
        name: str,
        pose: Optional[numpy.typing.ArrayLike] = None,
        *,
        q: Optional[numpy.typing.ArrayLike] = None,
        frame: str = "",
    ) -> Robot: ...
    def without(self, name: str) -> Robot: ...
    def allowing(self, a: str, b: str) -> Robot: ...
    # These return an array for many states and a numpy.void for one, with the fields of PAIR, LEVELED_PAIR or VERDICT.
    def minimum(self, q: numpy.typing.ArrayLike, *, accuracy: float | None = None, time_budget: float | None = None) -> Any: ...
    def level(self, q: numpy.typing.ArrayLike, *, time_budget: float | None = None) -> Any: ...
    def closest(
        self, q: numpy.typing.ArrayLike, k: int, *, time_budget: float | None = None
    ) -> numpy.typing.NDArray[numpy.void]: ...
    def below(self, q: numpy.typing.ArrayLike, distance: float, *, time_budget: float | None = None) -> Any: ...
    def pairs_below(
        self, q: numpy.typing.ArrayLike, distance: float, *, time_budget: float | None = None
    ) -> numpy.typing.NDArray[numpy.void]: ...
    def gradient(
        self, q: numpy.typing.ArrayLike, k: Optional[int] = None, *, time_budget: float | None = None
    ) -> tuple[Any, numpy.typing.NDArray[numpy.float64]]: ...
    # `uncertainty`: a number, a dict or YAML. Arrays for many states; a numpy.void and a float for one.
    def guaranteed(
        self, q: numpy.typing.ArrayLike, uncertainty: Any, *, time_budget: float | None = None
    ) -> tuple[Any, Any]: ...
    def free_motion(
        self,
        q: numpy.typing.ArrayLike,
        distance: float = 0.0,
        *,
        influence_distance: float = 0.2,
        time_budget: float | None = None,
    ) -> numpy.typing.NDArray[numpy.float64]: ...
    # An array for many states and a float for one.
    def free_scale(
        self,
        q: numpy.typing.ArrayLike,
        motion: numpy.typing.ArrayLike,
        distance: float = 0.0,
        *,
        influence_distance: float = 0.2,
        time_budget: float | None = None,
    ) -> Any: ...
    def prove(
        self,
        lower: Optional[numpy.typing.ArrayLike] = None,
        upper: Optional[numpy.typing.ArrayLike] = None,
        distance: float = 1e-6,
        *,
        boxes: int = 100000,
        time_budget: float | None = None,
        seconds: Optional[float] = None,
    ) -> tuple[numpy.typing.NDArray[numpy.void], numpy.typing.NDArray[numpy.float64]]: ...
    # An array, or a numpy.void, with the fields of POINT; with gradient=True a pair of it and an array of float64.
    def point_distance(
        self,
        q: numpy.typing.ArrayLike,
        points: numpy.typing.ArrayLike,
        radii: numpy.typing.ArrayLike = 0.0,
        *,
        links: Optional[Sequence[str]] = None,
        threshold: float = math.inf,
        gradient: bool = False,
        tolerance: float = 1e-9,
        time_budget: float | None = None,
    ) -> Any: ...
    # An array, or a numpy.void, with the fields of HIT.
    def first_hit(
        self,
        q: numpy.typing.ArrayLike,
        origins: numpy.typing.ArrayLike,
        directions: numpy.typing.ArrayLike,
        ranges: numpy.typing.ArrayLike = math.inf,
        *,
        links: Optional[Sequence[str]] = None,
        tolerance: float = 1e-9,
        time_budget: float | None = None,
    ) -> Any: ...
    def link_poses(self, q: numpy.typing.ArrayLike) -> numpy.typing.NDArray[numpy.float64]: ...
    # These return an array or a numpy.void as well, with the fields of CONTACT or EDGE_MINIMUM.
    def first_contact(
        self,
        start: numpy.typing.ArrayLike,
        goal: numpy.typing.ArrayLike,
        distance: float = 0.0,
        *,
        tolerance: float = 1e-6,
        velocities: Optional[_PairOfArrays] = None,
        accelerations: Optional[_PairOfArrays] = None,
        duration: numpy.typing.ArrayLike = 1.0,
        tracking_error: Optional[numpy.typing.ArrayLike] = None,
        time_budget: float | None = None,
    ) -> Any: ...
    def minimum_between(
        self,
        start: numpy.typing.ArrayLike,
        goal: numpy.typing.ArrayLike,
        *,
        tolerance: float = 1e-6,
        velocities: Optional[_PairOfArrays] = None,
        accelerations: Optional[_PairOfArrays] = None,
        duration: numpy.typing.ArrayLike = 1.0,
        tracking_error: Optional[numpy.typing.ArrayLike] = None,
        time_budget: float | None = None,
    ) -> Any: ...
