"""An FMU in a process of its own, as a slave: it may crash, hang or grow without taking the master with it.

A step is one request and one reply: the inputs written before it go with it, and the outputs come back with it.
"""

from __future__ import annotations

import logging
import math
import mmap
import tempfile
from collections.abc import Generator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any, cast

from cosim.errors import EndRequestError, FmuFileError, LostSlaveError, RunError, SlaveError, format_time
from cosim.fmi2.isolation.process import IsolatedProcess, Limits, ProcessLostError, Reply
from cosim.fmi2.isolation.protocol import TEXTS, Operation, shape_of, shared_block, shared_size
from cosim.recording.record import BASE_TYPES, Block
from cosim.system.description import Description, Variable
from cosim.system.signals import Value

_NOT_WRITTEN = -1
_STATE, _MOST_STATE = "state", 2**30


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
    folder : Path
        For the file through which values are exchanged.
    """

    def __init__(self, name: str, description: Description, process: IsolatedProcess, folder: Path) -> None:
        self.name = name
        self._description = description
        self._process = process
        self._folder = folder
        self._time = 0.0
        self._written = _NOT_WRITTEN
        self._up_to_date = False
        self._started = False
        self._lost = False
        self._times: dict[int, float] = {}
        self._block: Block
        self._shared: Block

    @property
    def description(self) -> Description:
        """Variables and capabilities."""
        return self._description

    def setup(self, block: Block, start_values: Mapping[Variable, Value], start_time: float, stop_time: float) -> None:
        """Share two rows of memory with the process, and have the start values set; times in s."""
        self._time = start_time
        self._block = block
        path = self._folder / "values"
        path.write_bytes(bytes(shared_size(block)))
        with path.open("r+b") as file:
            memory = mmap.mmap(file.fileno(), 0)
        self._shared = shared_block(block, memory)
        self._process.share(memory)
        values = [(variable.name, value) for variable, value in start_values.items()]
        content = {"memory": str(path), "shape": shape_of(block), "start_values": values}
        self._ask(Operation.SETUP, time_=start_time, size=stop_time, content=content)

    def enter_initialization(self) -> None:
        """Enter initialization mode."""
        self._ask(Operation.ENTER)

    def exit_initialization(self) -> None:
        """Exit initialization mode."""
        self._ask(Operation.EXIT)
        self._started = True

    def write(self, row: int) -> None:
        """Take the driven inputs from a row of the block; they are set together with what is asked for next."""
        shared = min(row, 1)
        for kind in BASE_TYPES:
            section = self._block.inputs[kind]
            if section.driven:
                self._shared.inputs[kind].values[shared, : section.driven] = section.values[row, : section.driven]
        if self._block.slopes is not None and self._shared.slopes is not None:
            self._shared.slopes.values[shared] = self._block.slopes.values[row]
        self._written = shared
        self._up_to_date = False

    def step(self, time: float, size: float) -> None:
        """Do one step from the communication point `time` [s] of the communication step size `size` [s]."""
        self._time = time
        self._ask(Operation.STEP, time_=time, size=size)
        self._time = time + size
        self._up_to_date = True

    def read(self, row: int) -> None:
        """Put the outputs into a row of the block."""
        if not self._up_to_date:
            self._ask(Operation.READ)
        for kind in BASE_TYPES:
            section = self._block.outputs[kind]
            if section.variables:
                section.values[row] = self._shared.outputs[kind].values[1]
        if self._started and self._block.output_slopes is not None and self._shared.output_slopes is not None:
            self._block.output_slopes.values[row] = self._shared.output_slopes.values[1]

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
        """Return the present state as bytes, which come through a file."""
        path = self._folder / _STATE
        self._ask(Operation.SERIALISE, content={"state": str(path)})
        return self._handed_over(path)

    def deserialise(self, content: bytes, time: float) -> None:
        """Go on from a state at the communication point `time` [s] that was written as bytes."""
        path = self._folder / _STATE
        path.write_bytes(content)
        self._ask(Operation.DESERIALISE, time_=time, content={"state": str(path)})
        self._time = time
        self._up_to_date = False

    def terminate(self) -> None:
        """Terminate the run."""
        self._started = False
        self._ask(Operation.TERMINATE)

    def open(self, path: Path, limits: Limits) -> None:
        """Load and instantiate the FMU."""
        try:
            self._process.await_start()
            content = {"name": self.name, "path": str(path), "memory": limits.memory}
            self._take(self._process.ask(Operation.OPEN, content=content))
        except ProcessLostError as error:
            raise RunError(f"{self.name}: the FMU {error}") from None

    def close(self) -> None:
        """Free the FMU; that it fails to end well is no reason to lose the results."""
        if self._lost:
            return
        try:
            self._take(self._process.ask(Operation.CLOSE))
        except ProcessLostError as error:
            logging.getLogger("cosim").warning("%s: the FMU %s", self.name, error)
        except RunError as error:
            logging.getLogger("cosim").warning("%s", error)

    def _told_time(self, told: object) -> float:
        """Return a time that the process has told, s; the present one in place of nonsense."""
        return told if isinstance(told, float) and math.isfinite(told) else self._time

    def _handed_over(self, path: Path) -> bytes:
        """Read a file that the process has written: a plain one of bounded size, as nothing it says is believed."""
        try:
            if not path.is_symlink() and path.is_file() and path.stat().st_size <= _MOST_STATE:
                return path.read_bytes()
        except OSError:
            pass
        raise RunError(f"{self.name} at t = {format_time(self._time)} s: the FMU's process handed over no state")

    def _ask(self, operation: Operation, **arguments: Any) -> None:
        """Have an operation done, and raise what it raises there."""
        write, self._written = self._written, _NOT_WRITTEN
        if write != _NOT_WRITTEN and (driven := self._shared.inputs["String"].driven):
            texts = self._shared.inputs["String"].values[write, :driven].tolist()
            arguments["content"] = {**arguments.get("content", {}), TEXTS: texts}
        try:
            reply = self._process.ask(operation, write=write, **arguments)
        except ProcessLostError as error:
            self._lost = True
            raise LostSlaveError(self.name, self._time, str(error)) from None
        self._take(reply)

    def _take(self, reply: Reply) -> None:
        """Log what the FMU has said, and raise what went wrong."""
        for message in reply.content.get("log", ()):
            level, category, says_why, text = message
            extra = {"category": str(category), "says_why": bool(says_why)}
            logging.getLogger(f"cosim.fmi2.{self.name}").log(int(level), "%s", text, extra=extra)
        if not reply.failed:
            self._take_texts(reply.content.get(TEXTS))
            return
        error = reply.content.get("error", {})
        if "end" in error:
            raise EndRequestError(self.name, self._time, str(error.get("message", "")), self._told_time(error["end"]))
        if "function" in error:
            what = (str(error[key]) for key in ("function", "status", "message"))
            raise SlaveError(self.name, self._time, *what)
        kind = FmuFileError if error.get("file") else RunError
        raise kind(str(error.get("text", "")))

    def _take_texts(self, texts: object) -> None:
        """Take strings that have been read there; what is no string, or one too many, is none."""
        if isinstance(texts, list):
            values = self._shared.outputs["String"].values
            for column, text in enumerate(cast(list[object], texts)[: values.shape[1]]):
                values[1, column] = str(text)


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
        process = IsolatedProcess(Path(folder), limits)
        try:
            slave = IsolatedSlave(name, description, process, Path(folder))
            slave.open(path, limits)
            try:
                yield slave
            finally:
                slave.close()
        finally:
            process.end()
