"""Types of the compiled part. Its docstrings are in the module itself: help(proximity.Robot)."""

import os
from typing import Any, Optional, Sequence, Union

import numpy
import numpy.typing

_Path = Union[str, os.PathLike[str]]

LEVELED_PAIR: numpy.dtype[numpy.void]
PAIR: numpy.dtype[numpy.void]
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
        mesh_tolerance: float = 0.005,
        packages: Optional[Sequence[_Path]] = None,
        padding: float = 0.0,
        group: str = "",
        exclude_pairs: Sequence[tuple[str, str]] = [],
        only_pairs: Sequence[tuple[str, str]] = [],
        thresholds: Optional[_Path] = None,
        threads: Optional[int] = None,
    ) -> None: ...
    @staticmethod
    def from_text(
        urdf: str,
        srdf: str = "",
        *,
        folder: _Path = ".",
        mesh_tolerance: float = 0.005,
        packages: Optional[Sequence[_Path]] = None,
        padding: float = 0.0,
        group: str = "",
        exclude_pairs: Sequence[tuple[str, str]] = [],
        only_pairs: Sequence[tuple[str, str]] = [],
        thresholds: str = "",
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
    def unchecked(self) -> list[tuple[str, str, str]]: ...
    @property
    def warnings(self) -> list[str]: ...
    @property
    def threads(self) -> int: ...
    @threads.setter
    def threads(self, threads: int) -> None: ...
    # An array for many states, a numpy.void for one; both have the fields of PAIR, LEVELED_PAIR or VERDICT.
    def minimum(self, q: numpy.typing.ArrayLike) -> Any: ...
    def level(self, q: numpy.typing.ArrayLike) -> Any: ...
    def closest(self, q: numpy.typing.ArrayLike, k: int) -> numpy.typing.NDArray[numpy.void]: ...
    def below(self, q: numpy.typing.ArrayLike, distance: float) -> Any: ...
    def pairs_below(self, q: numpy.typing.ArrayLike, distance: float) -> numpy.typing.NDArray[numpy.void]: ...
    def gradient(
        self, q: numpy.typing.ArrayLike, k: Optional[int] = None
    ) -> tuple[Any, numpy.typing.NDArray[numpy.float64]]: ...
