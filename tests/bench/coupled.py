"""One coupled system under four loops: FMUs called from C and nothing else, our two loops, and libcosim."""

from __future__ import annotations

import ctypes
from collections.abc import Callable, Mapping
from contextlib import ExitStack
from ctypes import c_size_t, c_uint, c_void_p
from functools import partial

from cosim import Component, Connection, System
from cosim.fmi2.fmu_slave import FmuSlave, open_fmu
from cosim.fmi2.locate import locate_fmu
from cosim.fmi2.model_description import read_description
from cosim.master.communication_points import Points, communication_points
from cosim.master.compiled_loop import StepLoop, loop_library
from cosim.master.fixed_step import readable_steps, window_block
from cosim.master.run import initialise
from cosim.master.wiring import Node, wire
from cosim.system.compatibility import check_system
from cosim.system.method import EXPLICIT
from tests.bench.native import importer, loops
from tests.importers.test_libcosimpy import build
from tests.plant.drive import Drive

STEP = 0.001
STEPS = 20_000
SYSTEM = System(
    (
        Component("plant", "DrillstringNeutral"),
        Component("law", "WeightOnBitLaw"),
        Component("program", "DrillingProgram"),
    ),
    (
        Connection("program.Omega", "plant.Omega"),
        Connection("law.WOB", "plant.WOB"),
        Connection("plant.bit_speed", "law.bit_speed"),
    ),
)


class Link(ctypes.Structure):
    """The struct `connection` of loop.c."""

    _fields_ = (("source", c_size_t), ("target", c_size_t), ("output", c_uint), ("input", c_uint))


class Alone:
    """The FMUs called from C, every output read, nothing recorded: their own time."""

    def __enter__(self) -> Alone:
        self._stack = ExitStack()
        fmus = {part.name: self._stack.enter_context(Drive(str(part.fmu), {})) for part in SYSTEM.components}
        places = {name: place for place, name in enumerate(fmus)}
        self._bound = [importer(fmu) for fmu in fmus.values()]
        self._pointers = (c_void_p * len(fmus))(*(ctypes.addressof(bound) for bound in self._bound))
        self._links = (Link * len(SYSTEM.connections))()
        for link, connection in zip(self._links, SYSTEM.connections, strict=True):
            source, target = connection.source, connection.target
            link.source = places[source.component]
            link.output = fmus[source.component].variables[source.variable].valueReference
            link.target = places[target.component]
            link.input = fmus[target.component].variables[target.variable].valueReference
        return self

    def __exit__(self, *_: object) -> None:
        self._stack.close()

    def run(self) -> None:
        """Take all steps."""
        arguments = self._pointers, len(self._pointers), self._links, len(self._links)
        assert loops().bench_coupled(*arguments, STEP, STEPS) == 0


class Master:
    """The FMUs in our master, everything recorded, with one of its two loops."""

    def __init__(self, *, compiled: bool) -> None:
        self._compiled = compiled

    def __enter__(self) -> Master:
        self._stack = ExitStack()
        files = {part.name: locate_fmu(part.fmu, "native", None) for part in SYSTEM.components}
        described = {name: read_description(path) for name, path in files.items()}
        slaves = {n: self._stack.enter_context(open_fmu(n, path, described[n])) for n, path in files.items()}
        start_values = check_system(SYSTEM, described)
        self._points = communication_points(0.0, STEPS * STEP, STEP, [], True).points()
        blocks = {n: window_block(SYSTEM, n, described[n], start_values[n], STEPS + 1) for n in files}
        nodes = wire(SYSTEM, slaves, blocks, 0.0, list(files), EXPLICIT["jacobi"])
        for node in nodes:
            node.slave.setup(node.block, start_values[node.name], 0.0, STEPS * STEP)
        initialise(nodes)
        self._steps = self._loop(slaves, nodes)
        return self

    def __exit__(self, *_: object) -> None:
        self._stack.close()

    def run(self) -> None:
        """Take all steps."""
        self._steps(self._points)

    def _loop(self, slaves: Mapping[str, FmuSlave], nodes: tuple[Node, ...]) -> Callable[[Points], None]:
        if not self._compiled:
            return readable_steps(nodes)
        library, why = loop_library(slaves)
        assert library is not None, why
        return StepLoop(library, nodes)


class Libcosim:
    """The FMUs in libcosim, nothing recorded."""

    def __enter__(self) -> Libcosim:
        self._execution = build(SYSTEM, STEP)
        return self

    def __exit__(self, *_: object) -> None:
        del self._execution

    def run(self) -> None:
        """Take all steps."""
        assert self._execution.step(STEPS)


LOOPS = {
    "FMUs alone": Alone,
    "compiled loop": partial(Master, compiled=True),
    "Python loop": partial(Master, compiled=False),
    "libcosim": Libcosim,
}
