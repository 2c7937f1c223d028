"""An FMU in a process of its own, as a slave: it may crash, hang or grow without taking the master with it.

A step is one request and one reply: the inputs written before it go with it, and the outputs come back with it.
"""

from __future__ import annotations

import logging
import tempfile
from collections.abc import Generator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from cosim.errors import LostSlaveError, RunError, format_time
from cosim.fmi2.isolation import Limits
from cosim.fmi2.isolation.process import IsolatedProcess, ProcessLostError, Reply
from cosim.fmi2.isolation.protocol import (
    MOST_STATE,
    TEXTS,
    Operation,
    RowBytes,
    driven_bytes,
    output_bytes,
    shape_of,
)
from cosim.recording.record import Block
from cosim.system.description import Description, Variable
from cosim.system.signals import Value

_NOT_WRITTEN = -1


class IsolatedSlave:
    """An FMU loaded in another process; made by `open_isolated_fmu`, which takes care of its end.

    Parameters
    ----------
    name : str
        Name of the instance, in every message.
    description : Description
        Of the FMU.
    process : IsolatedProcess
        In which it is loaded.
    """

    def __init__(self, name: str, description: Description, process: IsolatedProcess) -> None:
        self.name = name
        self._description = description
        self._process = process
        self._time = 0.0
        self._written = _NOT_WRITTEN
        self._up_to_date = False
        self._lost = False
        self.not_kept: dict[str, Value] = {}
        self._times: dict[int, float] = {}
        self._block: Block
        self._driven: RowBytes
        self._outputs: RowBytes
        self._driven_with: dict[str, Any] | None = None
        self._texts: list[str] = []

    @property
    def description(self) -> Description:
        """Variables and capabilities."""
        return self._description

    def setup(self, block: Block, start_values: Mapping[Variable, Value], start_time: float, stop_time: float) -> None:
        """Tell the process what the block is like, and have the start values set; times in s."""
        self._time = start_time
        self._block = block
        self._driven, self._outputs = driven_bytes(block), output_bytes(block)
        values = [(variable.name, value) for variable, value in start_values.items()]
        content = {"shape": shape_of(block), "start_values": values}
        self._ask(Operation.SETUP, time_=start_time, size=stop_time, content=content)

    def enter_initialization(self) -> None:
        """Enter initialization mode; a driven input that declares no start value begins with what it is in the FMU."""
        driven = self._driven.take(0)
        reply = self._ask(Operation.ENTER, data=driven, content=self._driven_texts(0), expected=len(driven))
        self._driven.load(reply.data)
        self._driven.put(0)
        section = self._block.inputs["String"]
        section.values[0, : section.driven] = self._told_texts(reply, section.driven)

    def exit_initialization(self) -> None:
        """Exit initialization mode, and take note of parameters that are not what they were set to."""
        content = self._ask(Operation.EXIT).content
        told = content.not_kept if content is not None else {}
        self.not_kept = {name: value for name, value in told.items() if name in self._description.by_name}

    def write(self, row: int) -> None:
        """Take the driven inputs from a row of the block; they are set together with what is asked for next."""
        self._driven.take(row)
        self._driven_with = self._driven_texts(row)
        self._written = min(row, 1)
        self._up_to_date = False

    def step(self, time: float, size: float) -> None:
        """Do one step from the communication point `time` [s] of the communication step size `size` [s]."""
        self._time = time
        self._take_outputs(self._ask(Operation.STEP, time_=time, size=size, expected=len(self._outputs.content)))
        self._time = time + size

    def read(self, row: int) -> None:
        """Put the outputs into a row of the block."""
        if not self._up_to_date:
            self._take_outputs(self._ask(Operation.READ, expected=len(self._outputs.content)))
        self._outputs.put(row)
        section = self._block.outputs["String"]
        if section.variables:
            section.values[row] = self._texts

    def save(self, slot: int) -> None:
        """Keep the present state under a number."""
        self._ask(Operation.SAVE, slot=slot)
        self._times[slot] = self._time

    def restore(self, slot: int) -> None:
        """Return to the state that was kept under a number."""
        self._ask(Operation.RESTORE, slot=slot)
        self._time = self._times[slot]
        self._up_to_date = False

    def serialise(self) -> bytes:
        """Return the present state as bytes."""
        return bytes(self._ask(Operation.SERIALISE, expected=MOST_STATE).data)

    def deserialise(self, content: bytes, time: float) -> None:
        """Go on from a state at the communication point `time` [s] that was written as bytes."""
        self._ask(Operation.DESERIALISE, time_=time, data=content)
        self._time = time
        self._up_to_date = False

    def terminate(self) -> None:
        """Terminate the run."""
        self._ask(Operation.TERMINATE)

    def open(self, path: Path, limits: Limits) -> None:
        """Load and instantiate the FMU."""
        try:
            self._process.await_start()
            content = {"name": self.name, "path": str(path), "memory": limits.memory}
            self._taken(self._process.ask(Operation.OPEN, content=content))
        except ProcessLostError as error:
            raise RunError(f"{self.name}: the FMU {error}") from None

    def close(self) -> None:
        """Free the FMU; that it fails to end well is no reason to lose the results."""
        if self._lost:
            return
        try:
            self._taken(self._process.ask(Operation.CLOSE))
        except ProcessLostError as error:
            logging.getLogger("cosim").warning("%s: the FMU %s", self.name, error)
        except RunError as error:
            logging.getLogger("cosim").warning("%s", error)

    def _ask(self, operation: Operation, **arguments: Any) -> Reply:
        """Have an operation done, and raise what it raises there."""
        write, self._written = self._written, _NOT_WRITTEN
        if write != _NOT_WRITTEN:
            arguments["data"], arguments["content"] = self._driven.content, self._driven_with
        try:
            reply = self._process.ask(operation, write, **arguments)
        except ProcessLostError as error:
            self._lost = True
            raise LostSlaveError(self.name, self._time, str(error)) from None
        except BaseException:  # an interrupt: whoever is in the middle of something is not asked to end well
            self._lost = True
            raise
        return self._taken(reply)

    def _taken(self, reply: Reply) -> Reply:
        """Log what the FMU has said, and raise what went wrong."""
        if reply.content is not None or reply.failed:
            from cosim.fmi2.isolation.reply import failure, log_messages  # with pydantic, which silent FMUs do without

            log_messages(self.name, reply.content)
            if reply.failed:
                raise failure(self.name, self._time, reply.content)
        return reply

    def _take_outputs(self, reply: Reply) -> None:
        """Keep the outputs that came with a reply until they are read."""
        self._outputs.load(reply.data)
        self._texts = self._told_texts(reply, len(self._block.outputs["String"].variables))
        self._up_to_date = True

    def _driven_texts(self, row: int) -> dict[str, Any] | None:
        """Return what goes with a row of driven inputs if there are strings among them."""
        section = self._block.inputs["String"]
        return {TEXTS: section.values[row, : section.driven].tolist()} if section.driven else None

    def _told_texts(self, reply: Reply, count: int) -> list[str]:
        """Return the strings that came with a reply, of which there have to be so many."""
        texts = [] if reply.content is None else reply.content.texts
        if len(texts) != count:
            how = f"told {len(texts)} strings where {count} were expected"
            raise RunError(f"{self.name} at t = {format_time(self._time)} s: the FMU's process {how}")
        return texts


@contextmanager
def open_isolated_fmu(
    name: str, path: Path, description: Description, limits: Limits | None = None
) -> Generator[IsolatedSlave]:
    """Load and instantiate an FMU in a process of its own, and end that afterwards, whatever happens.

    Parameters
    ----------
    name : str
        Name for the instance.
    path : Path
        The .fmu file.
    description : Description
        What `cosim.fmi2.model_description.read_description` read from it.
    limits : Limits, optional
        What it may use.

    Raises
    ------
    FmuFileError
        If there is no binary for this platform or it cannot be loaded.
    RunError
        If the FMU cannot be instantiated, or takes its process down.
    """
    limits = limits or Limits()
    with tempfile.TemporaryDirectory(prefix="cosim-", ignore_cleanup_errors=True) as folder:
        try:
            process = IsolatedProcess(Path(folder), limits)
        except OSError as error:
            raise RunError(f"{name}: no process can be started for the FMU: {error.strerror or error}") from error
        try:
            slave = IsolatedSlave(name, description, process)
            slave.open(path, limits)
            try:
                yield slave
            finally:
                slave.close()
        finally:
            process.end()
