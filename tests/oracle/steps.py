"""The march: bit motion and waves, piece by piece, through windows of one round trip.

With P = 2 L sqrt(I/(G J)), D the down-going and U the up-going wave as they pass the bit, and v the bit speed,

    D(t) = -Y U(t - P) + c_a/(c_a + Z) Omega(t - P/2),    U(t) = v(t) - D(t),
    I_B v' = 2 Z D - (Z + c_b) v - W R_b mu(|v|) sgn v,    mu = mu_cb + (mu_sb - mu_cb) exp(-gamma_b |v| / v_f).

Instants are kept as (window, offset), t = window P + offset. What happens at an offset comes back at that same offset
in every later window, so a delay is exact, no rounding gathers, and the places to cut are one sorted list of offsets.
"""

from __future__ import annotations

import math
from bisect import bisect_left, insort
from collections import defaultdict
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from tests.oracle.collocation import GaussBasis, evaluate
from tests.oracle.plant import OracleParameters, Program

MIN_GAP = 2e-13
"""Cuts closer than this [s] are one cut: it is the rounding of an instant near 1000 s."""
FADED = 1e-17
"""A cut is given up once reflections have shrunk what it carries by this factor."""
UNRESOLVED = 1e-13
"""Largest tail, relative to the polynomial, of a piece that need not be halved."""
SHORTEST_PIECE = 1e-7
ROUNDING = 1e-12


@dataclass
class Piece:
    """One smooth stretch: place, inputs, and the motion and waves at the Gauss nodes.

    `direction` is +1 or -1 when slipping and 0 when stuck; `source` is the up-going wave one round trip ago.
    """

    window: int
    start: float
    length: float
    omega: tuple[float, float]
    wob: tuple[float, float]
    source: np.ndarray
    down: np.ndarray
    direction: int = 0
    speed: np.ndarray | None = None


def _torque_rounding(static: np.ndarray) -> float:
    """Most by which a torque may seem to exceed the static one [N m] and be equal to it."""
    return ROUNDING * max(1.0, float(static.max()))


class WindowClock:
    """Turns times into (window, offset) pairs and back; fmod makes the offset exact."""

    def __init__(self, length: float):
        self.length = length

    def split(self, time: float) -> tuple[int, float]:
        """Window and offset of a time; a hair's breadth off a window's edge is on it."""
        offset = math.fmod(time, self.length)
        window = round((time - offset) / self.length)
        if self.length - offset < MIN_GAP:
            return window + 1, 0.0
        return window, offset if offset >= MIN_GAP else 0.0

    def arrival(self, time: float) -> tuple[int, float]:
        """Window and offset at which what happens at the top at `time` reaches the bit."""
        window, offset = self.split(time)
        half = self.length / 2
        if self.length - (offset + half) < MIN_GAP:
            late = offset - half
            return window + 1, late if late >= MIN_GAP else 0.0
        return window, offset + half

    def time(self, window: int, offset: float) -> float:
        """The time of an instant."""
        return window * self.length + offset


class Cuts:
    """Offsets at which the bit's motion or the wave it meets is not smooth, and the window each was last fed in."""

    def __init__(self, reflection: float):
        self.offsets: list[float] = []
        self.born: dict[float, int] = {}
        strength = abs(reflection)
        if strength >= 1:
            self.life = math.inf
        else:
            # The first return counts in full: the top's own motion holds the wave before it is reflected.
            self.life = 1 + (math.log(FADED) / math.log(strength) if strength > 0 else 0)

    def add(self, window: int, offset: float) -> float:
        """Cut at the offset, or at a cut already there; return the place."""
        index = bisect_left(self.offsets, offset - MIN_GAP)
        if index < len(self.offsets) and self.offsets[index] <= offset + MIN_GAP:
            offset = self.offsets[index]
        else:
            insort(self.offsets, offset)
        self.born[offset] = window
        return offset

    def drop_faded(self, window: int) -> None:
        """Forget the cuts whose reflections no longer matter."""
        self.offsets = [offset for offset in self.offsets if window - self.born[offset] <= self.life]
        self.born = {offset: self.born[offset] for offset in self.offsets}


class March:
    """Solves window after window; `pieces`, `releases`, `stops` and `crossings` hold what came out."""

    def __init__(
        self,
        parameters: OracleParameters,
        omega: Program,
        wob: Program,
        basis: GaussBasis,
        longest_piece: float,
    ):
        self.parameters, self.basis, self.longest_piece = parameters, basis, longest_piece
        self.omega, self.wob = omega, wob
        self.clock = WindowClock(2 * parameters.travel_time)
        self.cuts = Cuts(parameters.reflection)
        self.pieces: list[Piece] = []
        self.releases: list[tuple[int, float]] = []
        self.stops: list[tuple[int, float]] = []
        self.crossings: list[tuple[int, float]] = []
        self._speed = parameters.initial_speed
        self._direction = int(np.sign(self._speed))
        self._earlier: dict[tuple[float, float], np.ndarray] = {}
        self._earlier_grid: tuple[np.ndarray, np.ndarray, np.ndarray] | None = None
        # Where the departure from zero speed was entered, until the bit has moved.
        self._departure: list[tuple[int, float]] | None = None
        self._grazed: tuple[int, float] | None = None

    def run(self, horizon: float) -> None:
        """Solve every window that starts at or before `horizon` [s]."""
        scheduled = defaultdict(list)
        for window, offset in [*map(self.clock.arrival, self.omega.times), *map(self.clock.split, self.wob.times)]:
            scheduled[window].append(offset)
        for window in range(self.clock.split(horizon)[0] + 1):
            self.cuts.drop_faded(window)
            for offset in scheduled[window]:
                self.cuts.add(window, offset)
            self._cross_window(window)

    def _cross_window(self, window: int) -> None:
        first = len(self.pieces)
        marks = [0.0, *(offset for offset in self.cuts.offsets if offset > 0), self.clock.length]
        for left, right in pairwise(marks):
            count = math.ceil((right - left) / self.longest_piece)
            for start, end in pairwise([*(left + (right - left) * k / count for k in range(count)), right]):
                here = start
                while here < end:
                    here = self._advance(window, here, end)
        solved = self.pieces[first:]
        waves = np.array([piece.speed - piece.down for piece in solved])
        starts, lengths = (np.array([getattr(piece, name) for piece in solved]) for name in ("start", "length"))
        self._earlier = {(piece.start, piece.length): wave for piece, wave in zip(solved, waves, strict=True)}
        self._earlier_grid = starts, lengths, waves @ self.basis.to_coefficients.T

    def _advance(self, window: int, start: float, end: float) -> float:
        """Solve from start up to the first event, at most to end; return where that is."""
        piece = self._forced_piece(window, start, end)
        reached = None
        if self.basis.tail(piece.down) <= UNRESOLVED * (1 + np.abs(piece.down).max()):
            reached = self._stick(piece, end) if self._direction == 0 else self._slip(piece, end)
        if reached is None:
            if end - start < SHORTEST_PIECE:
                raise ArithmeticError(f"motion at t = {self.clock.time(window, start)} s is not resolved")
            return self._advance(window, start, (start + end) / 2)
        return reached

    def _forced_piece(self, window: int, start: float, end: float) -> Piece:
        """Return the piece with inputs and arriving wave, its motion still to be found."""
        constants, length = self.parameters, end - start
        begin, middle = self.clock.time(window, start), self.clock.time(window, (start + end) / 2)
        away = constants.travel_time
        omega, wob = self.omega.line(middle - away, begin - away), self.wob.line(middle, begin)
        elapsed = (self.basis.nodes + 1) * (length / 2)
        source = self._source(start, length, start + elapsed)
        if window == 0 and middle < away:
            down = np.full(self.basis.count, constants.initial_down)
        else:
            down = constants.transmission * (omega[0] + omega[1] * elapsed) - constants.reflection * source
        if wob[0] < 0 or wob[0] + wob[1] * length < -ROUNDING:
            raise ValueError(f"weight on bit is negative near t = {middle} s")
        return Piece(window, start, length, omega, wob, source, down)

    def _source(self, start: float, length: float, offsets: np.ndarray) -> np.ndarray:
        """Up-going wave at these offsets of the window before."""
        if self._earlier_grid is None:
            return np.full(self.basis.count, self.parameters.initial_up)
        known = self._earlier.get((start, length))
        if known is not None:
            return known
        starts, lengths, coefficients = self._earlier_grid
        index = np.maximum(np.searchsorted(starts, offsets, side="right") - 1, 0)
        return evaluate(coefficients[index], (offsets - starts[index]) * (2 / lengths[index]) - 1)

    def _drive_and_static(self, piece: Piece) -> tuple[np.ndarray, np.ndarray]:
        """Torque 2 Z D the string offers a bit at rest, and the static torque that can hold it, at the nodes."""
        constants = self.parameters
        weight = piece.wob[0] + piece.wob[1] * (self.basis.nodes + 1) * (piece.length / 2)
        return 2 * constants.impedance * piece.down, constants.R_b * constants.mu_sb * weight

    def _stick(self, piece: Piece, end: float) -> float:
        """Rest until the string's torque exceeds the static one."""
        drive, static = self._drive_and_static(piece)
        tolerance = _torque_rounding(static)
        again = self._grazed == (piece.window, piece.start)
        if again:
            # What is left over the static torque has been seen to move nothing: it is rounding.
            tolerance += 2 * max(0.0, abs(self.basis.at(drive, -1.0)) - self.basis.at(static, -1.0))
        falls = [(self.basis.first_fall(static - sign * drive, tolerance), sign) for sign in (1, -1)]
        found = min((fall for fall in falls if fall[0] is not None), default=None)
        piece.speed = np.zeros(self.basis.count)
        if found is None:
            self.pieces.append(piece)
            return end
        place = self._event_offset(piece, found[0], end)
        if place > piece.start:
            piece = self._forced_piece(piece.window, piece.start, place)
            piece.speed = np.zeros(self.basis.count)
            self.pieces.append(piece)
        elif again:
            time = self.clock.time(piece.window, piece.start)
            raise ArithmeticError(f"bit neither sticks nor slips at t = {time} s")
        self.releases.append((piece.window, place))
        self._direction, self._departure = found[1], self.releases
        return place

    def _slip(self, piece: Piece, end: float) -> float | None:
        """Turn until the speed reaches zero; None if the piece is too long to be resolved."""
        if not self._solve_motion(piece):
            return None
        basis, direction = self.basis, self._direction
        drive, static = self._drive_and_static(piece)
        # Without weight nothing happens at zero speed: no event, and no kink to cut at.
        found = None
        if static.any():
            found = basis.first_fall(direction * piece.speed, 1e-13, from_zero=self._speed == 0)
        if found is None:
            self.pieces.append(piece)
            self._speed, self._departure = self._end_speed(piece), None
            if not static.any() and self._speed:
                self._direction = int(np.sign(self._speed))
            return end
        place = self._event_offset(piece, found, end)
        if place == piece.start and self._speed == 0:
            return None if piece.length > 2 * SHORTEST_PIECE else self._rest_after_all(piece)
        offered, holding = basis.at(drive, found), basis.at(static, found)
        if place > piece.start:
            piece = self._forced_piece(piece.window, piece.start, place)
            if not self._solve_motion(piece):
                raise ArithmeticError("piece that ends in a stop is not resolved")
            self.pieces.append(piece)
        self._speed = 0.0
        # A tie is a rest, whichever way the two are rounded: a torque equal to the static one accelerates nothing.
        self._direction = 0 if abs(offered) <= holding + _torque_rounding(static) else int(np.sign(offered))
        self._departure = self.crossings if self._direction else None
        (self.crossings if self._direction else self.stops).append((piece.window, place))
        return place

    def _rest_after_all(self, piece: Piece) -> float:
        """Take back a departure that goes nowhere: the torque touches the static one to rounding and falls again."""
        self._direction, self._grazed = 0, (piece.window, piece.start)
        if self._departure:
            taken_back = self._departure.pop()
            if self._departure is self.crossings:
                self.stops.append(taken_back)
        self._departure = None
        return piece.start

    def _event_offset(self, piece: Piece, x: float, end: float) -> float:
        """Offset of an event at x, on an end of the piece if as good as there; a cut from now on."""
        offset = piece.start + (x + 1) * (piece.length / 2)
        if offset - piece.start < MIN_GAP:
            offset = piece.start
        elif end - offset < MIN_GAP:
            offset = end
        return offset if offset in (0.0, self.clock.length) else self.cuts.add(piece.window, offset)

    def _acceleration(self, piece: Piece, speed: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """v' and its derivative by v; the friction law is continued smoothly past v = 0."""
        constants, sign = self.parameters, self._direction
        drive, static = self._drive_and_static(piece)
        rate = constants.gamma_b / constants.v_f
        kinetic = constants.mu_cb / constants.mu_sb
        falling = static * (1 - kinetic) * np.exp(-rate * sign * speed)
        damping = constants.impedance + constants.c_b
        rest = drive - damping * speed - sign * (static * kinetic + falling)
        return rest / constants.I_B, (rate * falling - damping) / constants.I_B

    def _solve_motion(self, piece: Piece) -> bool:
        """Collocate v = v0 + integral of v' by Newton; False if it does not converge or is not resolved."""
        half, identity = piece.length / 2, np.eye(self.basis.count)
        speed = np.full(self.basis.count, self._speed)
        piece.direction = self._direction
        with np.errstate(all="ignore"):
            for _ in range(15):
                rate, slope = self._acceleration(piece, speed)
                residual = speed - self._speed - half * (self.basis.integration @ rate)
                jacobian = identity - half * self.basis.integration * slope
                if not (np.isfinite(residual).all() and np.isfinite(jacobian).all()):
                    return False
                step = np.linalg.solve(jacobian, residual)
                speed = speed - step
                if np.abs(step).max() < 1e-10 * (1 + np.abs(speed).max()):
                    piece.speed = speed
                    return self.basis.tail(speed) <= UNRESOLVED * (1 + np.abs(speed).max())
        return False

    def _end_speed(self, piece: Piece) -> float:
        """Speed at the end by Gauss quadrature of v', which is exact to twice the degree."""
        rate, _ = self._acceleration(piece, piece.speed)
        return self._speed + piece.length / 2 * float(self.basis.weights @ rate)
