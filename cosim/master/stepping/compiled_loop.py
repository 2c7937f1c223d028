"""Steps of a run with known communication points, taken in C where every component is an FMU of this process.

The loop to read is `readable_loop`. This one lays out the same calls on the same memory for the library of
`step_library`, which walks them. It comes back to Python after each window of rows, and where a call fails.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from ctypes import POINTER, Array, Structure, byref, c_int, c_size_t, c_void_p, cast
from typing import Any, TypeVar

import numpy as np

from cosim.errors import SlaveError
from cosim.fmi2.calls import Calls, Exchange, SlopeExchange
from cosim.fmi2.fmu_slave import FmuSlave
from cosim.master.communication_points import Points
from cosim.master.stepping.step_library import step_library
from cosim.master.stepping.wiring import Link, Node
from cosim.recording.slave import Slave

_WRITE, _INPUT_SLOPES, _DO_STEP, _READ, _OUTPUT_SLOPES = range(5)
"""Phases of a step, as step_loop.c numbers them."""


class _Link(Structure):
    _fields_ = (
        ("source", c_void_p),
        ("target", c_void_p),
        ("source_stride", c_size_t),
        ("target_stride", c_size_t),
        ("size", c_size_t),
        ("lag", c_size_t),
    )


class _Exchange(Structure):
    _fields_ = (
        ("call", c_void_p),
        ("references", c_void_p),
        ("count", c_size_t),
        ("values", c_void_p),
        ("stride", c_size_t),
    )


class _Slopes(Structure):
    _fields_ = (
        ("call", c_void_p),
        ("references", c_void_p),
        ("count", c_size_t),
        ("orders", c_void_p),
        ("values", c_void_p),
        ("stride", c_size_t),
    )


class _Node(Structure):
    _fields_ = (
        ("component", c_void_p),
        ("do_step", c_void_p),
        ("links", POINTER(_Link)),
        ("link_count", c_size_t),
        ("writes", POINTER(_Exchange)),
        ("write_count", c_size_t),
        ("reads", POINTER(_Exchange)),
        ("read_count", c_size_t),
        ("input_slopes", POINTER(_Slopes)),
        ("output_slopes", POINTER(_Slopes)),
    )


class _Failure(Structure):
    _fields_ = (
        ("row", c_size_t),
        ("node", c_size_t),
        ("phase", c_int),
        ("index", c_size_t),
        ("status", c_int),
    )


_Item = TypeVar("_Item", bound=Structure)


class StepLoop:
    """The steps of a run, laid out for the library; for slaves that `loop_library` has a library for.

    Parameters
    ----------
    library : ctypes.CDLL
        Of `cosim.master.stepping.step_library`.
    nodes : sequence of Node
        Set up, in stepping order, every slave an `FmuSlave`.
    """

    def __init__(self, library: Any, nodes: Sequence[Node]) -> None:
        self._slaves = [node.slave for node in nodes if isinstance(node.slave, FmuSlave)]
        self._calls: list[Calls] = [slave.calls() for slave in self._slaves]
        self._keep: list[object] = []
        laid_out = [self._lay_out(node, calls) for node, calls in zip(nodes, self._calls, strict=True)]
        self._nodes = (_Node * len(nodes))(*laid_out)
        self._step_rows = library.step_rows
        self._step_rows.restype = c_int
        self._step_rows.argtypes = (c_void_p, c_size_t, c_void_p, c_void_p, c_size_t, c_size_t, c_void_p)

    def __call__(self, points: Points) -> None:
        """Take the steps between communication points, which end in the rows from 1 on.

        Raises
        ------
        SlaveError
            If a component refuses a value or a step.
        """
        failure = _Failure()
        times, sizes, last = np.ascontiguousarray(points.times), np.ascontiguousarray(points.sizes), points.sizes.size
        addresses = times.ctypes.data, sizes.ctypes.data
        if self._step_rows(self._nodes, len(self._nodes), *addresses, 1, last, byref(failure)):
            raise self._error(failure, points)
        for slave in self._slaves:
            slave.arrive(float(times[last - 1] + sizes[last - 1]))

    def _lay_out(self, node: Node, calls: Calls) -> _Node:
        """Write a component as the struct of C."""
        return _Node(
            calls.instance,
            _address(calls.do_step),
            *self._array(_Link, [_lay_out_link(link) for link in node.links]),
            *self._array(_Exchange, [_lay_out_exchange(exchange) for exchange in calls.writes]),
            *self._array(_Exchange, [_lay_out_exchange(exchange) for exchange in calls.reads]),
            self._array(_Slopes, [_lay_out_slopes(calls.input_slopes)])[0] if calls.input_slopes else None,
            self._array(_Slopes, [_lay_out_slopes(calls.output_slopes)])[0] if calls.output_slopes else None,
        )

    def _array(self, kind: type[_Item], items: Sequence[_Item]) -> tuple[Array[_Item], int]:
        """Return an array of structs, kept alive, and its length."""
        array = (kind * len(items))(*items)
        self._keep.append(array)
        return array, len(items)

    def _error(self, failure: _Failure, points: Points) -> SlaveError:
        """Return what the slave itself would have raised."""
        node, row, phase = int(failure.node), int(failure.row), int(failure.phase)
        calls = self._calls[node]
        names = {
            _WRITE: [exchange.name for exchange in calls.writes],
            _READ: [exchange.name for exchange in calls.reads],
            _DO_STEP: ["fmi2DoStep"],
            _INPUT_SLOPES: ["fmi2SetRealInputDerivatives"],
            _OUTPUT_SLOPES: ["fmi2GetRealOutputDerivatives"],
        }[phase]
        time = float(points.times[row - 1])
        if phase > _DO_STEP:
            time += float(points.sizes[row - 1])
        slave = self._slaves[node]
        slave.arrive(time)
        return slave.failure(names[int(failure.index) if len(names) > 1 else 0], int(failure.status))


def loop_library(slaves: Mapping[str, Slave]) -> tuple[Any, str]:
    """Return the library, compiled now if need be; or None, and why steps are taken in Python."""
    foreign = [name for name, slave in slaves.items() if not isinstance(slave, FmuSlave)]
    if foreign:
        return None, f"{foreign[0]} is no FMU in this process"
    return step_library()


def _address(function: Any) -> c_void_p:
    """Return where a bound function is."""
    return cast(function, c_void_p)


def _lay_out_link(link: Link) -> _Link:
    """Write a connection as the struct of C: both ends are memory views of recordings."""
    source, source_column, target, target_column, lag = link
    ends = [(np.asarray(source), source_column), (np.asarray(target), target_column)]
    (begin, end) = (values.ctypes.data + column * values.itemsize for values, column in ends)
    strides = [values.strides[0] for values, _ in ends]
    return _Link(begin, end, *strides, ends[0][0].itemsize, lag)


def _lay_out_exchange(exchange: Exchange) -> _Exchange:
    """Write a getter or setter as the struct of C."""
    call = _address(exchange.function)
    return _Exchange(call, exchange.references, exchange.count, exchange.base, exchange.stride)


def _lay_out_slopes(exchange: SlopeExchange) -> _Slopes:
    """Write the setter or getter of derivatives as the struct of C."""
    call = _address(exchange.function)
    return _Slopes(call, exchange.references, exchange.count, exchange.orders, exchange.base, exchange.stride)
