"""What tests of sweeps measure, in the workers as well, which import it from here."""

from __future__ import annotations

import os
import signal
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from cosim.sweeps.measures import Output

OUTPUTS = ("bit_speed", "bit_angle", "energy", "stuck_time", "work_in")


@dataclass(frozen=True)
class Last:
    """Keep the last values of some outputs of the plant, after a long step and two short ones."""

    sampling: float | None = 1.0
    window: float = 2.0
    identity: str = "last"
    quantities = tuple(Output(name, "", "") for name in OUTPUTS)
    columns = tuple(f"plant.{name}" for name in OUTPUTS)

    def of(self, time: np.ndarray, columns: Mapping[str, np.ndarray]) -> Sequence[float]:
        del time
        return [float(columns[name][-1]) for name in self.columns]


@dataclass(frozen=True)
class Deadly(Last):
    """Kill the process of a point whose bit ends slower than a speed: always, or the first time."""

    slower: float = 0.0
    mark: Path | None = None

    def of(self, time: np.ndarray, columns: Mapping[str, np.ndarray]) -> Sequence[float]:
        found = super().of(time, columns)
        if found[0] < self.slower:
            if self.mark is None:
                os.kill(os.getpid(), signal.SIGKILL)
            elif not self.mark.exists():
                self.mark.touch()
                os.kill(os.getpid(), signal.SIGKILL)
        return found


@dataclass(frozen=True)
class Hungry(Last):
    """Have not enough memory where the bit ends slower than a speed."""

    slower: float = 0.0

    def of(self, time: np.ndarray, columns: Mapping[str, np.ndarray]) -> Sequence[float]:
        found = super().of(time, columns)
        if found[0] < self.slower:
            raise MemoryError
        return found
