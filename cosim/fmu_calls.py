"""What each step of an FMU calls: bare functions of its library, on addresses within the recording."""

from __future__ import annotations

from collections.abc import Callable
from ctypes import c_int, c_size_t, c_void_p
from dataclasses import dataclass


@dataclass(frozen=True)
class Exchange:
    """One getter or setter on a column range of a section; a row's values begin at `base` + row * `stride`."""

    function: Callable[[c_void_p, c_void_p, c_size_t, int], int]
    name: str
    references: c_void_p
    count: c_size_t
    base: int
    stride: int


@dataclass(frozen=True)
class SlopeExchange:
    """The setter or getter of first derivatives, and where those of a row are, as in `Exchange`."""

    function: Callable[[c_void_p, c_void_p, c_size_t, c_void_p, int], int]
    name: str
    references: c_void_p
    count: c_size_t
    orders: c_void_p
    base: int
    stride: int


@dataclass(frozen=True)
class Calls:
    """What a step calls: bare functions of the library, on addresses within the recording."""

    instance: c_void_p
    do_step: Callable[[c_void_p, float, float, c_int], int]
    writes: tuple[Exchange, ...]
    reads: tuple[Exchange, ...]
    input_slopes: SlopeExchange | None
    output_slopes: SlopeExchange | None
