"""The solved trajectory: every output at any time, from the pieces of the march."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.polynomial import legendre

from tests.oracle.collocation import GaussBasis, evaluate, gauss_basis
from tests.oracle.plant import OracleParameters, Program
from tests.oracle.steps import March, Piece, WindowClock

SNAP = 1e-12
"""A query this close [s] after a jump is at the jump, and gets the left limit."""


def solve(
    parameters: OracleParameters,
    omega: Program,
    wob: Program,
    end_time: float,
    *,
    nodes: int = 20,
    longest_piece: float = 0.015,
) -> OracleSolution:
    """Solve the drillstring with lossless string and set-valued dry friction on [0, end_time].

    Parameters
    ----------
    parameters : OracleParameters
        Constants and initial history.
    omega, wob : Program
        Speed of the drive [rad/s]; weight on bit [N], never negative.
    end_time : float
        Last time wanted [s].
    nodes, longest_piece : int, float
        Gauss nodes of a piece and its greatest length [s]. They are there to be varied when the solution is doubted.

    Raises
    ------
    ValueError
        If the weight on bit becomes negative.
    ArithmeticError
        If some stretch of the motion cannot be resolved.
    """
    omega, wob = omega.held_after(end_time), wob.held_after(end_time)
    march = March(parameters, omega, wob, gauss_basis(nodes), longest_piece)
    # The wave now leaving the top is the one that passes the bit a travel time later.
    march.run(end_time + parameters.travel_time + 10 * SNAP)
    return OracleSolution(parameters, march, end_time)


class _Pieces:
    """Columns of all pieces, and the way from a time to a piece and a place on it."""

    def __init__(self, pieces: list[Piece], clock: WindowClock):
        self.clock = clock
        self.window = np.array([piece.window for piece in pieces])
        self.start = np.array([piece.start for piece in pieces])
        self.length = np.array([piece.length for piece in pieces])
        self.direction = np.array([piece.direction for piece in pieces])
        self.omega = np.array([piece.omega for piece in pieces])
        self.wob = np.array([piece.wob for piece in pieces])
        # Complex numbers sort by real part, then imaginary part: by window, then offset.
        self._keys = self.window + 1j * self.start

    def find(self, times: np.ndarray, later_by: float) -> tuple[np.ndarray, np.ndarray]:
        """Piece index and x in [-1, 1] of times + later_by; left limits, but the right limit of time 0."""
        offset = np.fmod(times, self.clock.length)
        window = np.rint((times - offset) / self.clock.length)
        offset = offset + later_by
        early = np.where(times <= SNAP, -2 * SNAP, SNAP)
        over = np.floor((offset - early) / self.clock.length)
        window, offset = window + over, offset - over * self.clock.length
        index = np.searchsorted(self._keys, window + 1j * (offset - early), side="right") - 1
        index = np.clip(index, 0, len(self._keys) - 1)
        ahead = offset - self.start[index] + (window - self.window[index]) * self.clock.length
        return index, ahead * (2 / self.length[index]) - 1


class _Signal:
    """A quantity on all pieces, with its integral from time 0."""

    def __init__(self, pieces: _Pieces, basis: GaussBasis, values: np.ndarray, before: float):
        self._pieces, self._before = pieces, before
        self.coefficients = values @ basis.to_coefficients.T
        self._primitive = self.coefficients @ basis.antiderivative.T * (pieces.length / 2)[:, None]
        whole = values @ basis.weights * (pieces.length / 2)
        self._gathered = np.concatenate([[0.0], np.cumsum(whole.astype(np.longdouble))[:-1]]).astype(float)

    def value(self, times: np.ndarray, later_by: float = 0.0) -> np.ndarray:
        """Value at times + later_by."""
        index, x = self._pieces.find(times, later_by)
        found = evaluate(self.coefficients[index], x)
        return found if later_by >= 0 else np.where(times + later_by <= SNAP, self._before, found)

    def integral(self, times: np.ndarray, later_by: float = 0.0) -> np.ndarray:
        """Integral from 0 to times + later_by."""
        index, x = self._pieces.find(times, later_by)
        found = self._gathered[index] + evaluate(self._primitive[index], x)
        shifted = times + later_by
        return found if later_by >= 0 else np.where(shifted <= 0, self._before * shifted, found)


class OracleSolution:
    """Solution on [0, end_time]; call it with times [s] to get every output there.

    Outputs are left limits where they jump, and right limits at time 0.

    Attributes
    ----------
    releases, stops : ndarray
        Times at which the bit breaks loose and comes to rest. A bit that starts at rest under more than the static
        torque is released at 0; one that starts stuck has not stopped.
    crossings : ndarray
        Times at which the bit reverses without resting; neither a stop nor a release. With no weight on bit there is
        no friction and nothing is recorded.
    piece_count : int
        Polynomial pieces used, a measure of the work.
    """

    def __init__(self, parameters: OracleParameters, march: March, end_time: float):
        self.parameters, self.end_time = parameters, end_time
        self._clock, basis, pieces = march.clock, march.basis, march.pieces
        self.releases, self.stops, self.crossings = (
            self._times_of(events) for events in (march.releases, march.stops, march.crossings)
        )
        self.piece_count = len(pieces)
        self._at = _Pieces(pieces, march.clock)
        speed = np.array([piece.speed for piece in pieces])
        down = np.array([piece.down for piece in pieces])
        up, elapsed = speed - down, (basis.nodes + 1) / 2 * self._at.length[:, None]
        ahead = np.array([piece.source for piece in pieces])
        omega = self._at.omega[:, :1] + self._at.omega[:, 1:] * elapsed
        turning = np.arange(len(pieces))
        torque = self._torque_on(turning[:, None], speed, down, elapsed)

        def signal(values: np.ndarray, before: float) -> _Signal:
            return _Signal(self._at, basis, values, before)

        self._speed, self._down = signal(speed, parameters.initial_speed), signal(down, parameters.initial_down)
        self._up, self._up_squared = signal(up, parameters.initial_up), signal(up**2, parameters.initial_up**2)
        self._down_squared = signal(down**2, parameters.initial_down**2)
        self._loss = signal(torque * speed, 0.0)
        # What happens at the top is kept at the time it reaches the bit; the history before that is never asked for.
        self._top_speed = signal(ahead + down, parameters.initial_speed)
        self._work = signal(parameters.c_a * (omega - ahead - down) * (ahead + down), 0.0)
        self._driven = signal(parameters.c_a * (omega - ahead - down) * omega, 0.0)
        self._slid = signal(parameters.c_a * (omega - ahead - down) ** 2, 0.0)
        self._stuck_before = np.concatenate([[0.0], np.cumsum(np.where(self._at.direction == 0, self._at.length, 0.0))])
        self._releases_by_piece = np.searchsorted(
            [window + 1j * offset for window, offset in march.releases], self._at.window + 1j * self._at.start, "right"
        )

    def _times_of(self, events: list[tuple[int, float]]) -> np.ndarray:
        times = np.array([self._clock.time(*event) for event in events], dtype=float)
        return times[times <= self.end_time]

    def _torque_on(self, index: np.ndarray, speed: np.ndarray, down: np.ndarray, elapsed: np.ndarray) -> np.ndarray:
        """Torque on the bit: the law when it slips, the string's own when it is stuck."""
        constants, direction = self.parameters, self._at.direction[index]
        weight = self._at.wob[index, 0] + self._at.wob[index, 1] * elapsed
        falling = (constants.mu_sb - constants.mu_cb) * np.exp(-constants.gamma_b / constants.v_f * np.abs(speed))
        slipping = constants.c_b * speed + direction * weight * constants.R_b * (constants.mu_cb + falling)
        return np.where(direction == 0, 2 * constants.impedance * down, slipping)

    def __call__(self, times: np.ndarray) -> dict[str, np.ndarray]:
        """Every output at these times [s].

        Returns
        -------
        dict of ndarray
            bit_speed, top_speed [rad/s], bit_torque, top_torque [N m], bit_angle, top_angle [rad], bit_stuck (bool),
            energy [J], stuck_time [s], slip_count, work_in, bit_loss, drive_work, top_loss [J], shaped as `times`.

        Raises
        ------
        ValueError
            If a time is outside [0, end_time].
        """
        shape = np.shape(times)
        times = np.atleast_1d(np.asarray(times, dtype=float)).ravel()
        if times.size and not (times.min() >= 0 and times.max() <= self.end_time + SNAP):
            raise ValueError(f"times must be in [0, {self.end_time}] s")
        outputs = {**self._at_the_top(times), **self._at_the_bit(times), "energy": self._energy(times)}
        return {name: values.reshape(shape) for name, values in outputs.items()}

    def _at_the_top(self, times: np.ndarray) -> dict[str, np.ndarray]:
        constants, away = self.parameters, self.parameters.travel_time
        index, x = self._at.find(times, away)
        drive = self._at.omega[index, 0] + self._at.omega[index, 1] * (x + 1) / 2 * self._at.length[index]
        speed = self._top_speed.value(times, away)
        first = np.zeros(1)
        return {
            "top_speed": speed,
            "top_torque": constants.c_a * (drive - speed),
            "top_angle": constants.initial_torque * constants.L / (constants.G * constants.J)
            + self._top_speed.integral(times, away)
            - self._top_speed.integral(first, away),
            "work_in": self._work.integral(times, away) - self._work.integral(first, away),
            "drive_work": self._driven.integral(times, away) - self._driven.integral(first, away),
            "top_loss": self._slid.integral(times, away) - self._slid.integral(first, away),
        }

    def _at_the_bit(self, times: np.ndarray) -> dict[str, np.ndarray]:
        index, x = self._at.find(times, 0.0)
        elapsed = (x + 1) / 2 * self._at.length[index]
        speed, down = self._speed.value(times), self._down.value(times)
        stuck = self._at.direction[index] == 0
        return {
            "bit_speed": speed,
            "bit_torque": self._torque_on(index, speed, down, elapsed),
            "bit_angle": self._speed.integral(times),
            "bit_stuck": stuck,
            "stuck_time": self._stuck_before[index] + np.where(stuck, elapsed, 0.0),
            "slip_count": self._releases_by_piece[index],
            "bit_loss": self._loss.integral(times),
        }

    def _energy(self, times: np.ndarray) -> np.ndarray:
        """Waves under way, each side of the string as seen when it passes the bit, and the bit's own."""
        away = self.parameters.travel_time
        up = self._up_squared.integral(times) - self._up_squared.integral(times, -away)
        down = self._down_squared.integral(times, away) - self._down_squared.integral(times)
        return self.parameters.impedance * (up + down) + self.parameters.I_B * self._speed.value(times) ** 2 / 2

    def bit_speed_extremes(self, begin: float, end: float) -> tuple[float, float]:
        """Least and greatest bit speed on [begin, end]."""
        return _extremes(self._speed, self._at.find, begin, end)


def _extremes(signal: _Signal, find: Callable, begin: float, end: float) -> tuple[float, float]:
    """Least and greatest value of a continuous signal on [begin, end]."""
    (first, last), (left, right) = find(np.array([begin, end]), 0.0)
    seen = list(signal.value(np.array([begin, end])))
    for index in range(first, last + 1):
        coefficients = signal.coefficients[index]
        bounds = left if index == first else -1.0, right if index == last else 1.0
        derivative = legendre.legder(coefficients)
        turns = np.zeros(0)
        # The Legendre coefficients after the first bound how far the derivative strays from its mean.
        if derivative.any() and np.abs(derivative[1:]).sum() >= abs(derivative[0]):
            roots = legendre.legroots(legendre.legtrim(derivative, 1e-13 * np.abs(derivative).max()))
            turns = roots.real[np.abs(roots.imag) < 1e-6]
        inside = [x for x in turns if bounds[0] <= x <= bounds[1]]
        seen.extend(legendre.legval(np.array([*bounds, *inside]), coefficients))
    return float(min(seen)), float(max(seen))
