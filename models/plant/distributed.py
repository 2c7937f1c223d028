"""The drillstring of eqs. (1) to (4): the wave equation with damping along the string, and stations on it.

The neutral plant is the string without damping; what damping adds is in `models.plant.exchange` between the ends, and
in `models.plant.damped_end` at them. Without damping the waves, and with them all outputs, are those of the neutral
plant.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any, Self

from ..numerics.quartic import Quartic, square_integral
from .clock import SNAP, Ramp
from .damped_end import DampedBit, DampedTop
from .delay_line import Piece
from .exchange import Exchange, exchange
from .friction import TUNABLE
from .neutral import DrillstringNeutral, InitialState
from .parameters import DistributedParameters, DrillstringParameters
from .slip import BitLaw
from .station import StationOutputs, Stations
from .work import INPUT_CREDIT, earning


class DrillstringDistributed(DrillstringNeutral):
    """The plant with inputs Omega and WOB, damped along the string.

    Parameters
    ----------
    parameters : DistributedParameters
        The string.
    initial : InitialState
        Its motion before the start: uniform rotation, and the torque at the bit. The torque along the string is that of
        uniform rotation, so that it grows towards the top by beta times the speed per unit length.
    cells : int
        Cells in one travel time, at least 4; 0: chosen so that a cell is at most 0.5 ms.
    start : float
        Start time [s].
    omega, weight : float
        Omega [rad/s] and WOB [N] at the start, held until :meth:`set_inputs`.
    stations : int
        Places between top and bit that divide the string into equal parts.
    """

    parameters: DistributedParameters

    def __init__(
        self,
        parameters: DistributedParameters,
        initial: InitialState | None = None,
        cells: int = 0,
        start: float = 0.0,
        omega: float = 10.0,
        weight: float = 97347.0,
        stations: int = 2,
    ) -> None:
        self.part = stations + 1
        super().__init__(parameters, initial, cells, start, omega, weight)

    def _blocks(self) -> int:
        return self.parameters.blocks_for(self.cells, self.part - 1)

    def _begin(self, initial: InitialState) -> None:
        parameters = self.parameters
        self.constants = Exchange.of(parameters.exchange_rate * self.clock.block)
        self.damped = parameters.beta > 0.0
        self.bit.endow(earning(parameters.beta, parameters.travel_time, self.blocks))
        self.top_end = DampedTop(self.constants.strength)
        self.bit_end = DampedBit(self.constants.strength)
        self.string_loss = self.last_loss = 0.0
        drag = parameters.beta * initial.speed * parameters.L
        self.top.angle = (initial.torque + 0.5 * drag) / parameters.stiffness
        self.stations = Stations(self.part, self.constants.strength, self._initial_angle(initial))
        if self.damped:
            self._fill(initial)
        self.stations.find(self.up, self.down)
        self._open_top()
        self._open_bit()

    def _initial_angle(self, initial: InitialState) -> list[float]:
        """Return the angles at the stations before the start [rad]."""
        parameters = self.parameters
        drag = parameters.beta * initial.speed * parameters.L
        left = [1.0 - number / self.part for number in range(1, self.part)]
        return [below * (initial.torque + 0.5 * (drag * below)) / parameters.stiffness for below in left]

    def _fill(self, initial: InitialState) -> None:
        """Fill the lines with uniform rotation, each wave as it is before it crosses what it meets next."""
        blocks = self.up.count
        twice = 2.0 * self.impedance
        drag = self.parameters.beta * initial.speed * self.parameters.L  # N m, lost along the string
        slope = 0.5 * (drag / blocks) / twice
        for number in range(blocks):
            part = number / blocks
            up = initial.torque + drag * (1.0 - part)
            down = initial.torque + drag * part
            wave: Quartic = (0.5 * initial.speed - up / twice, slope, 0.0, 0.0, 0.0)
            self.up.pieces[number] = (0.0, 1.0, wave, square_integral(wave))
            wave = (0.5 * initial.speed + down / twice, slope, 0.0, 0.0, 0.0)
            self.down.pieces[number] = (0.0, 1.0, wave, square_integral(wave))
        for line in (self.up, self.down):
            line.square = 0.0
            for number in range(blocks):
                line.square = line.square + line.pieces[number][3]
        self.last_loss = drag * initial.speed * self.clock.block * (1.0 - 0.5 / blocks)
        self.string_loss = 0.25 * self.last_loss

    def set_inputs(self, omega: float, weight: float, omega_slope: float = 0.0, weight_slope: float = 0.0) -> None:
        """Set Omega [rad/s] and WOB [N] from now on, and their derivatives [1/s]."""
        top, bit = self.top, self.bit
        drive_changes = omega != top.omega.value or omega_slope != 0.0 or top.omega.slope != 0.0
        wob_changes = weight != bit.wob.value or weight_slope != 0.0 or bit.wob.slope != 0.0
        if not (drive_changes or wob_changes):
            return
        number, fraction = self.place
        turned = self._turn_at(fraction)
        if drive_changes:
            if top.block == number and top.cut(fraction):
                self._close_top()
            top.omega = Ramp(omega, omega_slope, number, fraction)
            bit.earn(INPUT_CREDIT)
        if wob_changes:
            if bit.block == number and bit.cut(fraction):
                self._close_bit_piece()
            bit.wob = Ramp(weight, weight_slope, number, fraction)
            bit.earn(INPUT_CREDIT)
        if drive_changes or turned:
            self._open_top()
        if wob_changes or turned:
            self._open_bit()

    def set_friction(self, parameters: DrillstringParameters) -> None:
        """Change the tunable parameters of the friction from now on."""
        friction = {name: getattr(parameters, name) for name in TUNABLE}
        self.parameters = replace(self.parameters, **friction)
        number, fraction = self.place
        turned = self._turn_at(fraction)
        if self.bit.block == number and self.bit.cut(fraction):
            self._close_bit_piece()
        self.bit.law = BitLaw.of(self.parameters)
        self.bit.earn(INPUT_CREDIT)
        if turned:
            self._open_top()
        self._open_bit()

    def _turn_at(self, fraction: float) -> bool:
        """If the present is at the end of the block, finish it; say so, as then both ends have to be opened."""
        if 1.0 - fraction > SNAP or self.top.block != self.place[0]:
            return False
        self._finish_block(1.0)
        return True

    def advance(self, time: float) -> None:
        """Go to a time [s], not before the present one; TooMuchWorkError, part of the way, if the bit is too fast."""
        self.bit.require_credit()
        number, fraction = self.clock.place(time)
        bit, top = self.bit, self.top
        x = self._present(bit)
        self.least, self.greatest = bit.extremes(x, x)
        while top.block < number:
            self._finish_block(x)
            self._open_top()
            self._open_bit()
            bit.require_credit()
            x = 0.0
        while top.end < fraction:
            self._close_top()
            self._open_top()
        while bit.end < fraction:
            self._widen(x, 1.0)
            self._close_bit_piece()
            self._open_bit()
            bit.require_credit()
            x = 0.0
        self.place = (number, fraction)
        self._widen(x, self._present(bit))

    def _finish_block(self, x: float) -> None:
        """Go to the end of the block, and let the waves cross; the range of the bit from x of its piece on counts."""
        bit, top = self.bit, self.top
        block = top.block
        self._close_top()
        while top.block == block:
            self._open_top()
            self._close_top()
        self._widen(x, 1.0)
        self._close_bit_piece()
        while bit.block == block:
            self._open_bit()
            bit.require_credit()
            self._widen(0.0, 1.0)
            self._close_bit_piece()
        self.stations.turn(self.up, self.down, self.clock.block)
        if self.damped:
            self.last_loss = self.impedance * self.clock.block * exchange(self.up, self.down, self.constants)
            self.string_loss = self.string_loss + self.last_loss
        self.stations.move(self.up, self.down)

    def _open_top(self) -> None:
        if self.damped:
            self.top_end.open(self.top, self.up)
        else:
            self.top.open(self.up)

    def _close_top(self) -> None:
        if self.damped:
            self.top_end.close(self.top, self.down)
        else:
            self.top.close(self.down)

    def _open_bit(self) -> None:
        if self.damped:
            self.bit_end.open(self.bit, self.down)
        else:
            self.bit.open(self.down)

    def _close_bit_piece(self) -> None:
        if self.damped:
            self.bit_end.close(self.bit, self.up)
        else:
            self.bit.close(self.up)

    def loss_along_string(self) -> float:
        """Return the energy lost along the string since the start [J]."""
        top, bit = self.top, self.bit
        ends = self.top_end.square_by(top, self._present(top)) + self.bit_end.square_by(bit, self._present(bit))
        at_ends = self.constants.strength * self.impedance * self.clock.block * ends
        return (self.string_loss + at_ends) - self._still_stored()

    def _still_stored(self) -> float:
        """Return what the cells have taken from the waves before its time [J].

        A cell takes it at once, between blocks. The part of the cells that the present has already passed grows
        steadily, by one row of cells a block.
        """
        elapsed = (self.place[0] - self.top.block) + self.place[1]
        return self.last_loss * (0.25 - elapsed)

    def _coming(self) -> tuple[Piece, Piece]:
        return (self.top_end.raw, self.bit_end.raw) if self.damped else super()._coming()

    def _energy(self, x: float, y: float) -> float:
        energy = super()._energy(x, y)
        if self.damped:
            settled = self.top_end.settled_by(self.top, y) + self.bit_end.settled_by(self.bit, x)
            energy = energy + self.impedance * self.clock.block * settled
        return energy + self._still_stored()

    def station_outputs(self) -> list[StationOutputs]:
        """Return what is read at the stations, from the top downwards, at the present time."""
        elapsed = (self.place[0] - self.top.block) + self.place[1]
        top_angle = self.outputs().top_angle
        found: list[StationOutputs] = []
        for angle, r in self.stations.read(self.up, self.down, elapsed):
            turned = angle + self.clock.block * r.turned
            found.append(StationOutputs(r.up + r.down, self.impedance * (r.down - r.up), top_angle - turned))
        return found

    def _parts(self) -> list[object]:
        return [*super()._parts(), self.top_end, self.bit_end, *self.stations]

    def state(self) -> dict[str, Any]:
        """Return everything that changes in time, as plain data that survives JSON to the last bit."""
        return super().state() | {
            "top_end": self.top_end.state(),
            "bit_end": self.bit_end.state(),
            "stations": self.stations.state(),
            "losses": [self.string_loss, self.last_loss],
        }

    @classmethod
    def restored(cls, state: dict[str, Any]) -> Self:
        """Return the plant that :meth:`state` was asked of, as it was then."""
        parameters = DistributedParameters(**state["parameters"])
        plant = cls(parameters, None, state["cells"], state["start"], stations=len(state["stations"]))
        plant.restore(state)
        return plant

    def restore(self, state: dict[str, Any]) -> None:
        """Take a state of :meth:`state` back; the plant must have the same parameters, cells and stations."""
        super().restore(state)
        self.top_end.restore(state["top_end"])
        self.bit_end.restore(state["bit_end"])
        self.stations.restore(state["stations"])
        self.string_loss, self.last_loss = state["losses"]
