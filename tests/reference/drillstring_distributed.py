"""Reference experiments of the damped plant: the oracle, and uniform rotation in closed form."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from fmu_src.fmus.DrillstringDistributed.interface import MODEL
from tests.oracle import OracleParameters, OracleSolution
from tests.plant import theory
from tests.reference.drillstring_neutral import DEFAULTS, DIGITS, TOLERANCES, Plant
from tests.reference.experiment import Answers, Experiment, Points, Tolerance, held

MOST_STATIONS = int(MODEL.variables[MODEL.value_reference("stations")].bounds[1])
QUANTITIES = ("speed", "torque", "twist")

_ALONG = "as top_speed and top_torque: a station reads the same waves, farther down"
_CELLS = "the energy in the cells, whose error falls with their second power"
_UNUSED = "there is no such station"

LOSSES = {
    "string_loss": Tolerance("as work_in; the damping is followed to a part in 1e8", 1e-2, 3e-7),
}


def tolerances(stations: int) -> dict[str, Tolerance]:
    """Return how far outputs may be off, for a string with some stations."""
    along = {"speed": Tolerance(_ALONG, 1e-6), "torque": Tolerance(_ALONG, 2e-3), "twist": Tolerance(_ALONG, 5e-6)}
    read = {
        f"station_{number}_{quantity}": along[quantity] if number <= stations else Tolerance(_UNUSED)
        for number in range(1, MOST_STATIONS + 1)
        for quantity in QUANTITIES
    }
    return TOLERANCES | LOSSES | read


@dataclass(frozen=True)
class Undamped:
    """The oracle's solution, and what its waves are along the string, the drive being held between jumps."""

    plant: Plant
    parameters: OracleParameters
    omega: Points
    stations: int

    def jumps(self) -> np.ndarray:
        """Return when an output may jump, at the ends or at a station [s]."""
        at_ends = np.concatenate([[0.0], self.plant.jumps()])
        parts = np.arange(1 - self.stations - 1, self.stations + 1) / (self.stations + 1)
        every = np.add.outer(at_ends, parts * self.parameters.travel_time).ravel()
        return every[every > 0.0]

    def answer(self, times: np.ndarray, step_size: float) -> Answers:
        """Return every output of the FMU that does not tell of its own method."""
        answers = dict(self.plant.answer(times, step_size))
        solution = self.plant.solution()
        answers["string_loss"] = np.zeros(len(times))
        for number in range(1, MOST_STATIONS + 1):
            for quantity, values in zip(QUANTITIES, self._read(solution, times, number), strict=True):
                answers[f"station_{number}_{quantity}"] = values
        return answers

    def _drive_turned(self, times: np.ndarray) -> np.ndarray:
        """Return the angle of the drive [rad]."""
        return np.interp(times, *self._steps(np.array([value for _, value in self.omega])))

    def _steps(self, rates: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return times, and at these the integral of a rate that is held between them."""
        begins = np.array([time for time, _ in self.omega])
        ends = np.append(begins[1:], 1e6)
        return np.append(begins, 1e6), np.append(0.0, np.cumsum(rates * (ends - begins)))

    @staticmethod
    def _top_angle(solution: OracleSolution, times: np.ndarray) -> np.ndarray:
        return solution(np.asarray(times, dtype=float))["top_angle"]

    def _waves(self, solution: OracleSolution, times: np.ndarray) -> tuple[np.ndarray, ...]:
        """Return the waves up and down at the top, and their integrals from the start [rad/s, rad]."""
        p = self.parameters
        before = np.minimum(times, 0.0)
        now = solution(np.maximum(times, 0.0))
        slip = self._drive_turned(np.maximum(times, 0.0)) - (now["top_angle"] - self._top_angle(solution, 0.0 * times))
        turned = now["top_angle"] - self._top_angle(solution, 0.0 * times)
        pushed = p.c_a * slip / p.impedance
        down = np.where(times < 0.0, p.initial_down, 0.5 * (now["top_speed"] + now["top_torque"] / p.impedance))
        up = np.where(times < 0.0, p.initial_up, 0.5 * (now["top_speed"] - now["top_torque"] / p.impedance))
        return (
            up,
            down,
            0.5 * (turned - pushed) + p.initial_up * before,
            0.5 * (turned + pushed) + p.initial_down * before,
        )

    def _read(self, solution: OracleSolution, times: np.ndarray, number: int) -> tuple[np.ndarray, ...]:
        """Return speed, torque and twist at a station; zero if there is none."""
        if number > self.stations:
            return (np.zeros(len(times)),) * 3
        away = self.parameters.travel_time * number / (self.stations + 1)
        up, _, up_turned, _ = self._waves(solution, times + away)
        _, down, _, down_turned = self._waves(solution, times - away)
        _, _, up_here, down_here = self._waves(solution, times)
        twist = (up_here - up_turned) + (down_here - down_turned)
        return up + down, self.parameters.impedance * (down - up), twist


@dataclass(frozen=True)
class Rotation:
    """A damped string in uniform rotation."""

    parameters: OracleParameters
    beta: float
    weight: float
    stations: int

    @property
    def omega(self) -> float:
        """Drive speed that keeps it up [rad/s]."""
        p = self.parameters
        return p.initial_speed + (p.initial_torque + self.beta * p.L * p.initial_speed) / p.c_a

    def answer(self, times: np.ndarray, step_size: float) -> Answers:
        """Return every output of the FMU that does not tell of its own method."""
        del step_size
        p, speed, torque = self.parameters, self.parameters.initial_speed, self.parameters.initial_torque
        one, drag = np.ones(len(times)), self.beta * self.parameters.L * self.parameters.initial_speed
        square = torque**2 + torque * drag + drag**2 / 3
        shear = p.G * p.J
        answers = {
            "bit_speed": speed * one, "top_speed": speed * one, "bit_torque": torque * one,
            "top_torque": (torque + drag) * one, "bit_angle": speed * times,
            "top_angle": speed * times + p.L * (torque + drag / 2) / shear, "bit_stuck": one < 0.0,
            "energy": (0.5 * (p.L * p.I + p.I_B) * speed**2 + p.L * square / (2 * shear)) * one,
            "bit_speed_min": speed * one, "bit_speed_max": speed * one, "stuck_time": 0.0 * one,
            "slip_count": np.zeros(len(times), int), "last_stop_time": 0.0 * one, "last_release_time": 0.0 * one,
            "work_in": (torque + drag) * speed * times, "bit_loss": torque * speed * times,
            "drive_work": (torque + drag) * self.omega * times,
            "top_loss": (torque + drag) * (self.omega - speed) * times, "string_loss": drag * speed * times,
        }  # fmt: skip
        for number in range(1, MOST_STATIONS + 1):
            depth = number / (self.stations + 1)
            there = one if number <= self.stations else 0.0 * one
            answers[f"station_{number}_speed"] = speed * there
            answers[f"station_{number}_torque"] = (torque + drag * (1 - depth)) * there
            answers[f"station_{number}_twist"] = p.L * (torque * depth + drag * (depth - depth**2 / 2)) / shear * there
        return answers


def _undamped(
    name: str, description: str, stop_time: float, step_size: float, every: int, stations: int | None,
    parameters: Mapping[str, float], inputs: Mapping[str, Points],
) -> Experiment:  # fmt: skip
    plant = Plant(stop_time + 2.0, parameters, inputs)
    read = 2 if stations is None else stations
    omega = [point for number, point in enumerate((DEFAULTS | inputs)["Omega"]) if number % 2 == 0]
    string = Undamped(plant, OracleParameters(**parameters), omega, read)
    allowed = tolerances(read) | {"string_loss": Tolerance("there is no damping along the string")}
    given = {**parameters, **({} if stations is None else {"stations": stations})}
    return Experiment(
        name, description, stop_time, step_size, every, string.answer, allowed, given, inputs, DIGITS,
        string.jumps,
    )  # fmt: skip


def _rotation() -> Experiment:
    weight, speed, beta, stations = 60000.0, 8.0, 0.05, 9
    string = replace(OracleParameters(), L=1800.0, initial_speed=speed)
    string = replace(string, initial_torque=theory.torque_on_bit(string, weight, speed))
    rotation = Rotation(string, beta, weight, stations)
    return Experiment(
        "uniform-rotation", "Uniform rotation of a string with damping along it, nine stations read", 10.0, 0.05, 2,
        rotation.answer, tolerances(stations) | {"energy": Tolerance(_CELLS, 1e-2, 1e-6)},
        {
            "L": string.L, "beta": beta, "stations": stations, "initial_speed": speed,
            "initial_torque": string.initial_torque,
        },
        {"Omega": held((0.0, rotation.omega)), "WOB": held((0.0, weight))}, DIGITS,
    )  # fmt: skip


EXPERIMENTS = (
    _undamped("stick-slip", "Nothing set: stick-slip from rest, Fig. 2 of the paper", 20.0, 0.01, 20, None, {}, {}),
    _undamped(
        "another-string", "Another string, which starts turning, and wound up backwards; nine stations read",
        12.0, 0.1, 1, 9,
        {
            "G": 82e9, "J": 1.4e-5, "I": 0.11, "L": 1500.0, "I_B": 120.0, "c_a": 1500.0, "c_b": 0.5, "R_b": 0.12,
            "mu_cb": 0.45, "mu_sb": 0.7, "gamma_b": 0.7, "v_f": 1.3, "initial_speed": 5.0, "initial_torque": -15000.0,
        },
        {"Omega": held((0.0, 9.0), (6.0, 12.0)), "WOB": held((0.0, 90000.0))},
    ),
    _rotation(),
)  # fmt: skip
