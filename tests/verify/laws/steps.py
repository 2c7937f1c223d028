"""The plant against the method of steps, which shares no code with it."""

from __future__ import annotations

from functools import cache

import numpy as np

from models.plant.parameters import DrillstringParameters
from models.theory.cycle.cycle import LimitCycle, limit_cycle
from tests.oracle import OracleSolution
from tests.plant.drive import follow
from tests.plant.judge import BARS, EVENT_BAR, RELATIVE_BARS, Judgement, judge
from tests.plant.programs import CASES, PAPER, RAMPS, solved
from tests.plant.theory import slope_of_torque
from tests.verify.finding import Finding, greatest, law

SECTION = "Method of steps"
FIGURE_2 = "stick-slip of figure 2"
STEP = 0.0137
PIECE = "the plant halves its pieces until what they leave out is below 1e-6 rad/s"
RELEASES = 2e-9
"""Of an interval between two events of the method of steps, each of which two solvers found to 1e-9 s [s]."""


@cache
def judged(name: str) -> Judgement:
    """Return a case driven at communication points that no event is on, beside the method of steps."""
    case = (CASES | RAMPS)[name]
    grid = np.arange(1, int(case.end / STEP) + 1) * STEP
    return judge(case.parameters, case.omega, case.wob, grid, solved(name))


def worst(quantities: tuple[str, ...] | list[str], names: list[str]) -> float:
    """Return the greatest error of some quantities in some cases."""
    return greatest(judged(name).errors[quantity] for name in names for quantity in quantities)


@law(SECTION)
def speeds_of_figure_2_are_those_of_the_method_of_steps() -> Finding:
    """Bit and top turn as the equations say, over 100 s of Fig. 2"""
    found = worst(["bit_speed", "top_speed"], [FIGURE_2])
    events = len(solved(FIGURE_2).stops) + len(solved(FIGURE_2).releases)
    return Finding(
        f"both speeds every {STEP} s, over {events} stops and releases", found, BARS["bit_speed"], PIECE, "rad/s"
    )


@law(SECTION)
def torques_of_figure_2_are_those_of_the_method_of_steps() -> Finding:
    """Torques of Fig. 2 are the equations', while the bit slips and while it is held"""
    steepest = -slope_of_torque(PAPER, 97347.0, 0.0)
    found = worst(["bit_torque", "top_torque"], [FIGURE_2])
    reason = f"1e-6 rad/s on the steepest part of (4), {steepest:.0f} N m s/rad"
    return Finding("torque on bit and on top over 100 s", found, BARS["bit_speed"] * steepest, reason, "N m")


@law(SECTION)
def speeds_of_other_strings_and_programs_are_those_of_the_method_of_steps() -> Finding:
    """Other strings, jumps, ramps, reversals and a lifted weight give the equations' motion as well"""
    names = [name for name in (CASES | RAMPS) if name != FIGURE_2]
    found = worst(["bit_speed", "top_speed"], names)
    return Finding(f"both speeds of {len(names)} cases", found, BARS["bit_speed"], PIECE, "rad/s")


@law(SECTION)
def stops_and_releases_are_those_of_the_method_of_steps() -> Finding:
    """Every stop and release comes, and when it is due"""
    errors: list[float] = []
    for name in CASES | RAMPS:
        solution = solved(name)
        end = judged(name).run.times[-1]
        for output, events in (("last_stop_time", solution.stops), ("last_release_time", solution.releases)):
            seen = np.unique(judged(name).run[output])
            for event in events[events < end - STEP]:
                later = events[events > event]
                if not later.size or later[0] > event + STEP:  # the last before a communication point is put out
                    errors.append(float(np.abs(seen - event).min()))
    reason = "1e-6 rad/s at an acceleration of 10 rad/s²"
    return Finding(f"{len(errors)} instants of {len(CASES | RAMPS)} cases", greatest(errors), EVENT_BAR, reason, "s")


@law(SECTION)
def energies_are_those_of_the_method_of_steps() -> Finding:
    """Stored energy, work and losses are those of the equations, each accumulated by itself"""
    found = worst(list(RELATIVE_BARS), list(CASES | RAMPS))
    reason = "as a part of the energy that has passed: 1e-6 rad/s in some 100 rad/s that add up over waves and slips"
    return Finding("energy, work_in, bit_loss, drive_work, top_loss", found, RELATIVE_BARS["energy"], reason)


@law(SECTION)
def python_packaging_gives_the_bits_of_the_native_one() -> Finding:
    """The readable model is the compiled one"""
    case = CASES["inputs that jump on no grid"]
    grid = np.arange(1, 600) * STEP
    runs = [follow(case.parameters, case.omega, case.wob, grid, packaging) for packaging in ("native", "python")]
    differ = sum(int((runs[0][name] != runs[1][name]).sum()) for name in runs[0].names)
    reason = "equality: in stick-slip a tolerance would prove nothing"
    return Finding(f"all {len(runs[0].names)} outputs at {len(grid)} points", differ, 0.0, reason, "values")


@cache
def cycle() -> tuple[LimitCycle, OracleSolution]:
    """Return the cycle of Fig. 2 by its own equations, and a simulation of 100 s."""
    return limit_cycle(DrillstringParameters(), 10.0, 97347.0), solved(FIGURE_2)


@law(SECTION)
def limit_cycle_is_where_a_long_simulation_ends() -> Finding:
    """The cycle solved for as such is the one that simulations end in"""
    found, simulated = cycle()
    error = abs(found.period - float(np.diff(simulated.stops[-2:])[0]))
    reason = "two instants known to 1e-9 s; the rest of the way to the cycle has faded to 1e-11"
    return Finding("period of Fig. 2, equations of a cycle and last stops in 100 s", error, RELEASES, reason, "s")


@law(SECTION)
def bit_rests_in_the_cycle_as_in_a_long_simulation() -> Finding:
    """The share of rest in the cycle is that of simulations"""
    found, simulated = cycle()
    begin, end = simulated.stops[-2:]
    rest = float(np.diff(simulated(np.array([begin, end]))["stuck_time"])[0]) / (end - begin)
    reason = "two instants known to 1e-9 s in a period"
    return Finding("stuck fraction of Fig. 2", abs(found.stuck_fraction - rest), RELEASES / found.period, reason)
