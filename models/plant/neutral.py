"""The drillstring as a neutral delay system, eqs. (14) and (15), in the form of waves it is computed in."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from typing import Any, NamedTuple, Self

from ..numerics.quartic import integral, product_integral, restrict, square_integral, subtract, value
from .bit import Bit
from .clock import Clock, Ramp, blocks_for
from .delay_line import DelayLine, Piece
from .kept import Kept
from .parameters import DrillstringParameters
from .slip import BitLaw
from .top import Top
from .work import INPUT_CREDIT


@dataclass(frozen=True)
class InitialState:
    """Uniform rotation [rad/s] and uniform transmitted torque [N m] of the string before the start."""

    speed: float = 0.0
    torque: float = 0.0


class Outputs(NamedTuple):
    """The outputs of the plant, named and ordered as in the interface of the FMU; SI units."""

    bit_speed: float
    top_speed: float
    bit_torque: float
    top_torque: float
    bit_angle: float
    top_angle: float
    bit_stuck: bool
    energy: float
    bit_speed_min: float
    bit_speed_max: float
    stuck_time: float
    slip_count: int
    last_stop_time: float
    last_release_time: float
    work_in: float
    bit_loss: float
    drive_work: float
    top_loss: float
    cells_used: int
    breaks_folded: int
    folded_energy: float


class DrillstringNeutral:
    """The plant with inputs Omega and WOB.

    The waves between the ends are two delay lines; each end is one piece ahead of what has left it, so that the
    result does not depend on where the communication points lie as long as the inputs are held.

    Parameters
    ----------
    parameters : DrillstringParameters
        The string.
    initial : InitialState
        Its motion before the start.
    cells : int
        Cells in one travel time, at least 4; 0: chosen so that a cell is at most 0.5 ms.
    start : float
        Start time [s].
    omega, weight : float
        Omega [rad/s] and WOB [N] at the start, held until :meth:`set_inputs`.
    """

    def __init__(
        self,
        parameters: DrillstringParameters,
        initial: InitialState | None = None,
        cells: int = 0,
        start: float = 0.0,
        omega: float = 10.0,
        weight: float = 97347.0,
    ) -> None:
        initial = initial if initial is not None else InitialState()
        self.parameters = parameters
        self.cells = parameters.cells_for(cells)
        self.blocks = blocks = self._blocks()
        self.clock = Clock(start, parameters.travel_time / blocks)
        self.impedance = parameters.impedance
        twist = initial.torque / (2.0 * self.impedance)
        self.up = DelayLine(blocks, 0.5 * initial.speed - twist, self.clock.coarseness)
        self.down = DelayLine(blocks, 0.5 * initial.speed + twist, self.clock.coarseness)
        self.top = Top(parameters, self.clock, initial.torque / parameters.stiffness, Ramp(omega))
        self.bit = Bit(BitLaw.of(parameters), self.clock, initial.speed, Ramp(weight))
        self.place = (0, 0.0)
        self.least = self.greatest = initial.speed
        self._begin(initial)

    def _blocks(self) -> int:
        """Return the blocks in a travel time."""
        return blocks_for(self.cells)

    def _begin(self, initial: InitialState) -> None:
        """Take up the first pieces."""
        self.top.open(self.up)
        self.bit.open(self.down)

    def set_inputs(self, omega: float, weight: float, omega_slope: float = 0.0, weight_slope: float = 0.0) -> None:
        """Set Omega [rad/s] and WOB [N] from now on, and their derivatives [1/s]."""
        number, fraction = self.place
        top, bit = self.top, self.bit
        if omega != top.omega.value or omega_slope != 0.0 or top.omega.slope != 0.0:
            if top.block == number and top.cut(fraction):
                top.close(self.down)
            top.omega = Ramp(omega, omega_slope, number, fraction)
            bit.earn(INPUT_CREDIT)
            top.open(self.up)
        if weight != bit.wob.value or weight_slope != 0.0 or bit.wob.slope != 0.0:
            if bit.block == number and bit.cut(fraction):
                bit.close(self.up)
            bit.wob = Ramp(weight, weight_slope, number, fraction)
            bit.earn(INPUT_CREDIT)
            bit.open(self.down)

    def set_friction(self, parameters: DrillstringParameters) -> None:
        """Change the tunable parameters of the friction from now on."""
        self.parameters = parameters
        number, fraction = self.place
        if self.bit.block == number and self.bit.cut(fraction):
            self.bit.close(self.up)
        self.bit.law = BitLaw.of(parameters)
        self.bit.earn(INPUT_CREDIT)
        self.bit.open(self.down)

    def advance(self, time: float) -> None:
        """Go to a time [s], not before the present one; TooMuchWorkError, part of the way, if the bit is too fast."""
        self.bit.require_credit()
        number, fraction = self.clock.place(time)
        bit, top = self.bit, self.top
        x = self._present(bit)
        self.least, self.greatest = bit.extremes(x, x)
        while top.block < number or bit.block < number:
            # an input that changes at the end of a block has put one of them ahead
            block = top.block if top.block < bit.block else bit.block
            while top.block == block:
                top.close(self.down)
                top.open(self.up)
            while bit.block == block:
                x = self._close_bit(x)
        while top.end < fraction:
            top.close(self.down)
            top.open(self.up)
        while bit.end < fraction:
            x = self._close_bit(x)
        self.place = (number, fraction)
        self._widen(x, self._present(bit))

    def _close_bit(self, x: float) -> float:
        """Finish the piece of the bit, whose range from x on counts, and return where the next begins."""
        self._widen(x, 1.0)
        self.bit.close(self.up)
        self.bit.open(self.down)
        self.bit.require_credit()
        return 0.0

    def _widen(self, x0: float, x1: float) -> None:
        """Let the range of bit speeds cover [x0, x1] of the piece."""
        low, high = self.bit.extremes(x0, x1)
        if low < self.least:
            self.least = low
        if high > self.greatest:
            self.greatest = high

    def _present(self, end: Top | Bit) -> float:
        """Return where in the piece of an end the present lies."""
        number, fraction = self.place
        if end.block != number or fraction <= end.begin:
            return 0.0
        return (fraction - end.begin) / (end.end - end.begin)

    def outputs(self) -> Outputs:
        """Return the outputs at the present time: left limits after :meth:`advance`, right limits after a new input."""
        bit, top, block = self.bit, self.top, self.clock.block
        x = self._present(bit)
        y = self._present(top)
        bit_piece = (bit.end - bit.begin) * block
        top_piece = (top.end - top.begin) * block
        work, driven, slid = top.power_integrals(y)
        return Outputs(
            bit_speed=value(bit.turning, x),
            top_speed=value(top.speed(), y),
            bit_torque=bit.torque(x),
            top_torque=top.torque(y),
            bit_angle=bit.angle + bit_piece * integral(bit.turning, x),
            top_angle=top.angle + top_piece * integral(top.speed(), y),
            bit_stuck=bit.direction == 0,
            energy=self._energy(x, y),
            bit_speed_min=self.least,
            bit_speed_max=self.greatest,
            stuck_time=bit.stuck + x * bit_piece if bit.direction == 0 else bit.stuck,
            slip_count=bit.slips,
            last_stop_time=bit.last_stop,
            last_release_time=bit.last_release,
            work_in=top.work + top_piece * work,
            bit_loss=bit.loss + bit_piece * bit.power_integral(x),
            drive_work=top.driven + top_piece * driven,
            top_loss=top.slid + top_piece * slid,
            cells_used=self.cells,
            breaks_folded=self.up.folded + self.down.folded,
            folded_energy=self.impedance * block * (self.up.folded_square + self.down.folded_square),
        )

    def _energy(self, x: float, y: float) -> float:
        """Return the energy stored in the string and the bit, (I L / 2) E of eq. (7) [J]."""
        bit, top = self.bit, self.top
        up = self.up.square + self.up.square_rest
        from_bit, from_top = self._coming()
        up += _square_after(from_bit, top.begin + y * (top.end - top.begin))
        wave = subtract(bit.turning, bit.incident)
        up += (bit.end - bit.begin) * product_integral(wave, wave, x)
        down = self.down.square + self.down.square_rest
        down += _square_after(from_top, bit.begin + x * (bit.end - bit.begin))
        down += (top.end - top.begin) * product_integral(top.outgoing, top.outgoing, y)
        speed = value(bit.turning, x)
        return self.impedance * self.clock.block * (up + down) + 0.5 * self.parameters.I_B * (speed * speed)

    def _coming(self) -> tuple[Piece, Piece]:
        """Return the incident pieces at the top and at the bit."""
        return self.top.incoming, self.bit.incoming

    def keep(self) -> Kept:
        """Return what the plant is now, to be put back if a step is refused."""
        return Kept(self, (self.up, self.down), self._parts())

    def _parts(self) -> list[object]:
        """Return what changes in time beside the lines."""
        return [self.top, self.bit]

    def state(self) -> dict[str, Any]:
        """Return everything that changes in time, as plain data that survives JSON to the last bit."""
        return {
            "up": self.up.state(),
            "down": self.down.state(),
            "top": self.top.state(),
            "bit": self.bit.state(),
            "place": list(self.place),
            "range": [self.least, self.greatest],
            "parameters": asdict(self.parameters),
            "cells": self.cells,
            "start": self.clock.start,
        }

    @classmethod
    def restored(cls, state: dict[str, Any]) -> Self:
        """Return the plant that :meth:`state` was asked of, as it was then."""
        plant = cls(DrillstringParameters(**state["parameters"]), None, state["cells"], state["start"])
        plant.restore(state)
        return plant

    def restore(self, state: dict[str, Any]) -> None:
        """Take a state of :meth:`state` back; the plant must have the same parameters and cells."""
        self.up.restore(state["up"])
        self.down.restore(state["down"])
        self.top.restore(state["top"])
        self.bit.restore(state["bit"])
        number, fraction = state["place"]
        self.place = (number, fraction)
        self.least, self.greatest = state["range"]
        self.parameters = type(self.parameters)(**state["parameters"])
        self.bit.law = BitLaw.of(self.parameters)


def _square_after(piece: Piece, fraction: float) -> float:
    """Return the integral of the squared wave of a piece from a fraction of the block to its end, in blocks."""
    begin, end, wave, _ = piece
    rest = restrict(wave, (fraction - begin) / (end - begin), 1.0)
    return (end - fraction) * square_integral(rest)
