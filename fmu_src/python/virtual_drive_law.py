"""Do what the laws have in common that make the drive a virtual one. native/ds_virtual_drive_law.h follows."""

from __future__ import annotations

from abc import abstractmethod
from typing import Any

from fmu_src.python.switched_law import SwitchedLaw
from models.controllers.virtual_drive import Ends, Gains, Motion, TopOfString, VirtualDrive

_HELD = Ends(0.0, 0.0, 0.0)


class VirtualDriveLaw(SwitchedLaw):
    """A law that makes the drive meet the string as a damper, spring and mass do.

    The law's own memory is the motion of the virtual drive and, after it, its gains, which do not change.
    """

    @abstractmethod
    def gains_of(self, values: list[Any], string: TopOfString) -> Gains:
        """Return what the string is to meet, from the parameters."""

    def remember(self, values: list[Any]) -> tuple[float, ...]:
        """Begin as if the inputs had been so for ever."""
        gains = self.gains_of(values, self._string(values))
        return (*self._drive(gains, values).begin(self._ends(values)), *gains)

    def go_on(self, own: tuple[float, ...], values: list[Any], elapsed: float) -> tuple[float, ...]:
        """Move the virtual drive, in the background too."""
        gains, ends = Gains(*own[4:]), self._ends(values)
        return (*self._drive(gains, values).advance(Motion(*own[:4]), ends, ends, _HELD, elapsed), *gains)

    def ask(self, own: tuple[float, ...], values: list[Any]) -> float:
        """Ask for what makes the waves at the top those of the virtual drive."""
        return self._drive(Gains(*own[4:]), values).command(Motion(*own[:4]), self._ends(values))

    def _string(self, values: list[Any]) -> TopOfString:
        return TopOfString(*(values[self.at[name]] for name in ("G", "J", "I", "L", "I_B", "c_a")))

    def _ends(self, values: list[Any]) -> Ends:
        return Ends(*(values[self.at[name]] for name in Ends._fields))

    def _drive(self, gains: Gains, values: list[Any]) -> VirtualDrive:
        times = (values[self.at["filter_time"]], values[self.at["slip_time"]])
        return VirtualDrive(
            self._string(values).impedance, values[self.at["c_a"]], gains, *times, values[self.at["slip"]] == 2
        )
