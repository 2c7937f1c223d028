"""What each step of an FMU calls: bare functions of its library, on addresses within the recording.

The addresses are good for as long as the block is kept whose memory they lead to.
"""

from __future__ import annotations

from collections.abc import Callable
from ctypes import c_int, c_size_t, c_void_p
from dataclasses import dataclass
from typing import Any, cast

from cosim.recording.record import Section, Slopes


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


def bound(library: Any, name: str, argument_types: tuple[Any, ...]) -> Callable[..., int]:
    """Return a bare function of a library; indexing makes a new object, so fmpy's keeps its own types."""
    function = library[name]
    function.argtypes = argument_types
    function.restype = c_int
    return cast(Callable[..., int], function)


def exchange(library: Any, verb: str, kind: str, section: Section, count: int) -> Exchange:
    """Bind a getter or setter to the first `count` columns of a section."""
    name = f"fmi2{verb}{kind}"
    return Exchange(
        bound(library, name, (c_void_p, c_void_p, c_size_t, c_void_p)),
        name,
        c_void_p(section.references.ctypes.data),
        c_size_t(count),
        section.values.ctypes.data,
        section.values.strides[0],
    )


def slope_exchange(library: Any, name: str, slopes: Slopes | None) -> SlopeExchange | None:
    """Bind the setter or getter of derivatives, if there are any."""
    if slopes is None:
        return None
    return SlopeExchange(
        bound(library, name, (c_void_p, c_void_p, c_size_t, c_void_p, c_void_p)),
        name,
        c_void_p(slopes.references.ctypes.data),
        c_size_t(slopes.references.size),
        c_void_p(slopes.orders.ctypes.data),
        slopes.values.ctypes.data,
        slopes.values.strides[0],
    )
