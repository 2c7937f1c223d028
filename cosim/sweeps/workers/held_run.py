"""Run components that nothing couples and nothing moves, again and again with other values, at little cost.

Memory, wiring and the compiled loop are laid out once. What differs from run to run is written over: values of driven
inputs in the rows, parameters before initialisation.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence

import numpy as np

from cosim.errors import EndRequestError
from cosim.master.communication_points import Points, within
from cosim.master.compiled_loop import StepLoop, loop_library
from cosim.master.fixed_step import exchanged_texts, readable_steps, window_block
from cosim.master.run import Snapshot, initialise
from cosim.master.slave import Slave
from cosim.master.wiring import wire
from cosim.recording.record import base_type
from cosim.system.compatibility import StartValues, convert
from cosim.system.description import Variable
from cosim.system.signals import FloatArray, Value
from cosim.system.structure import Port, System


class HeldRun:
    """Components with constant inputs, between given communication points.

    Parameters
    ----------
    system : System
        Without connections; all its signals are constants.
    slaves : mapping of str to Slave
        Instantiated, by name of component.
    start_values : mapping
        By component.
    times : ndarray, shape (n + 1,)
        Communication points, s.
    first : int
        Number of the one at which the window begins that is asked for.
    columns : sequence of str
        Outputs that are asked for, as ``component.variable``.
    step_size : float, optional
        Of all steps, as exactly as any run takes it, s; else from point to point.
    """

    def __init__(
        self,
        system: System,
        slaves: Mapping[str, Slave],
        start_values: StartValues,
        times: FloatArray,
        first: int,
        columns: Sequence[str],
        step_size: float | None = None,
    ) -> None:
        self._slaves = dict(slaves)
        self._times, self._step_size = times, step_size
        self._start_values = start_values
        descriptions = {name: slave.description for name, slave in slaves.items()}
        self._blocks = {
            name: window_block(system, name, descriptions[name], start_values[name], times.size) for name in slaves
        }
        self._nodes = wire(system, slaves, self._blocks, float(times[0]), tuple(slaves))
        self._variables = {
            Port(name, variable.name): variable
            for name, description in descriptions.items()
            for variable in description.variables
        }
        self._driven = frozenset(system.inputs)
        texts = next(exchanged_texts(system, descriptions), None)
        self._library = None if texts is not None else loop_library(slaves)[0]
        self._steps: Callable[[Points], EndRequestError | None] | None = None
        self._columns = {name: self._column(Port.parse(name)) for name in columns}
        self._first = first
        self.window = times[first:]

    def is_of(self, slaves: Mapping[str, Slave]) -> bool:
        """Tell whether these are the instances it was laid out for."""
        return all(self._slaves[name] is slave for name, slave in slaves.items())

    def run(
        self, values: Mapping[str, Value], offset: float, stop: float, state: Snapshot | None
    ) -> dict[str, FloatArray]:
        """Run from the first to the last communication point.

        Parameters
        ----------
        values : mapping of str to value
            That are set, by ``component.variable``.
        offset : float
            By how much all communication points are later, s.
        stop : float
            Time that components are told to be the last, s.
        state : Snapshot, optional
            To go on from; without it the components are initialised at the first point.

        Returns
        -------
        dict of str to ndarray
            The columns, over the window.

        Raises
        ------
        RunError
            If a component fails.
        """
        starts = {name: dict(given) for name, given in self._start_values.items()}
        for name, value in values.items():
            self._set(Port.parse(name), value, starts)
        begin = float(self._times[0])
        for name, slave in self._slaves.items():
            slave.setup(self._blocks[name], starts[name], begin, stop)
        initialise(self._nodes)
        if state is not None:
            for name, slave in self._slaves.items():
                slave.deserialise(state.arrays[name].tobytes(), begin + offset)
        times = self._times + offset
        points = Points(times, self._sizes(times, stop), times)
        if self._steps is None:  # as the components are set up
            self._steps = readable_steps(self._nodes) if self._library is None else StepLoop(self._library, self._nodes)
        if (end := self._steps(points)) is not None:
            raise end
        return {name: cells[self._first :].astype(np.float64) for name, cells in self._columns.items()}

    def _sizes(self, times: FloatArray, stop: float) -> FloatArray:
        """Return the sizes of the steps between communication points, s."""
        if self._step_size is None:
            return np.diff(times)
        sizes = np.full(times.size - 1, self._step_size)
        sizes[-1] = within(float(times[-2]), self._step_size, stop)
        return sizes

    def state(self) -> Snapshot:
        """Return the states of all components."""
        arrays = {name: np.frombuffer(slave.serialise(), np.uint8) for name, slave in self._slaves.items()}
        return Snapshot({}, arrays)

    def _set(self, port: Port, value: Value, starts: Mapping[str, dict[Variable, Value]]) -> None:
        """Put a value among those that are set before initialisation, or into the rows where it drives an input."""
        variable: Variable = self._variables[port]
        number = convert(port, variable, value)
        if port not in self._driven:
            starts[port.component][variable] = number
            return
        section = self._blocks[port.component].inputs[base_type(variable)]
        section.values[:, section.column(port.variable)] = number

    def _column(self, port: Port) -> np.ndarray[tuple[int], np.dtype[np.generic]]:
        """Return the memory of an output."""
        section = self._blocks[port.component].outputs[base_type(self._variables[port])]
        return section.values[:, section.column(port.variable)]
