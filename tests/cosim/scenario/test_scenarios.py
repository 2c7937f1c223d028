"""The scenarios on the built FMUs; reference numbers from a method-of-steps solution good to 1e-9."""

from __future__ import annotations

import re
from pathlib import Path

import pytest
from typer.testing import CliRunner

from cosim import LoopError, load_scenario, simulate
from cosim.cli.app import app
from cosim.drilling.oscillation import Measures, measure
from cosim.report.statement import statement
from cosim.run.report import CouplingReport
from cosim.scenario.file import scenario_names


def measures(name: str, **options) -> Measures:
    found = measure(simulate(load_scenario(name), **options))
    assert found is not None
    return found


def test_stick_slip_prints_the_limit_cycle_of_fig_2(tmp_path: Path) -> None:
    result = CliRunner().invoke(app, ["run", "stick-slip", "--output", str(tmp_path / "run")])
    assert result.exit_code == 0, result.output
    for text in ("period [s]", "3.2256227", "peak [rad/s]", "18.7605", "0.458836"):
        assert text in result.stdout


@pytest.mark.parametrize("step_size", [0.001, 0.0137, 0.1])
def test_measures_of_the_limit_cycle_do_not_depend_on_the_communication_step(step_size: float) -> None:
    found = measures("stick-slip", step_size=step_size)
    assert f"{found.period:.7f}" == "3.2256227"
    assert f"{found.peak:.4f}" == "18.7605"
    assert f"{found.stuck_fraction:.6f}" == "0.458836"


@pytest.mark.parametrize(("name", "speed"), [("lower-wob", 8.768644096751), ("higher-speed", 16.213565871)])
def test_less_weight_or_more_speed_ends_in_steady_rotation(name: str, speed: float) -> None:
    result = simulate(load_scenario(name))
    assert result["plant.bit_speed"][-1] == pytest.approx(speed, abs=1e-6)
    found = measure(result)
    assert found is not None
    assert found.period is None
    assert found.stuck_fraction == 0.0


@pytest.mark.parametrize(
    ("variant", "peak", "period"),
    [("c_b=0.8", 18.7324, 3.224275), ("c_b=15", 18.2929, 3.212047), ("c_b=65", 16.8969, 3.203594)],
)
def test_bit_damping_lowers_the_peak_of_the_cycle(variant: str, peak: float, period: float) -> None:
    found = measures("bit-damping", variant=variant)
    assert found.peak == pytest.approx(peak, abs=5e-5)
    assert found.period == pytest.approx(period, abs=5e-7)


def test_enough_bit_damping_ends_the_cycle() -> None:
    found = measures("bit-damping", variant="c_b=150")
    assert found.period is None
    assert found.mean_speed == pytest.approx(5.768533359, abs=1e-5)


@pytest.mark.parametrize(("algorithm", "steps"), [("gauss-seidel", 1), ("jacobi", 2)])
def test_the_weight_follows_the_bit_speed_by_the_steps_of_the_algorithm(algorithm: str, steps: int) -> None:
    result = simulate(load_scenario("wob-law"), stop_time=5.0, algorithm=algorithm)
    law = (97347.0 + 5000.0 * abs(result["plant.bit_speed"])).clip(max=300000.0)
    assert result["plant.WOB"].max() > 140000.0
    assert result["plant.WOB"][steps:] == pytest.approx(law[:-steps], rel=1e-12)


def test_the_dissipative_law_runs_in_both_forms_and_reports_its_limits() -> None:
    scenario = load_scenario("dissipative-law")
    printed = simulate(scenario, variant="printed", stop_time=10.0)
    assert printed["law.limit_active"].any()
    assert abs(printed["plant.Omega"]).max() <= 40.0
    tracking = simulate(scenario, variant="tracking", stop_time=60.0)
    assert tracking["plant.bit_speed"][-1000:] == pytest.approx(10.0, abs=0.5)


def test_the_printed_law_has_no_solution_with_the_plant_and_the_implicit_algorithm_says_so(tmp_path: Path) -> None:
    scenario = load_scenario("dissipative-law")
    with pytest.raises(LoopError) as caught:
        simulate(scenario, variant="printed", algorithm="implicit")
    error = caught.value
    assert error.time == 0.0
    assert error.variables == ("plant.Omega", "plant.top_speed", "law.top_speed", "law.Omega")
    assert error.residual > 1.0
    sentence = (
        r"t = 0\.00 s: plant\.Omega -> plant\.top_speed -> law\.top_speed -> law\.Omega -> plant\.Omega "
        r"has no solution: where plant\.Omega passes .* law\.Omega jumps from 40 rad/s to -40 rad/s; "
        r"law\.guard_active and law\.limit_active are on there\. "
        r"The least residual of \d+ trials is [\d.]+ rad/s\. Try "
    )
    assert re.match(sentence, str(error))
    arguments = ["run", "dissipative-law", "--variant", "printed", "--algorithm", "implicit", "--output"]
    result = CliRunner().invoke(app, [*arguments, str(tmp_path / "run")])
    assert result.exit_code == 1
    assert result.stderr.strip() == f"error: {error}"
    assert result.stdout == ""
    assert list(tmp_path.iterdir()) == []


@pytest.mark.slow
def test_the_printed_law_goes_on_explicitly_only_where_asked_and_owns_up_to_it(
    caplog: pytest.LogCaptureFixture,
) -> None:
    options = {"variant": "printed", "algorithm": "implicit", "stop_time": 2.0}
    with pytest.raises(LoopError, match="has no solution"):
        simulate(load_scenario("dissipative-law"), on_failure="halve", **options)
    result = simulate(load_scenario("dissipative-law"), on_failure="explicit", **options)
    unsolved = result.record["unsolved"]
    assert unsolved["first"] == 0.0
    assert unsolved["steps"] > 0.5 * result.record["steps"]
    assert "has no solution" in caplog.text
    assert "going on" in caplog.text
    (loop, *_) = statement(CouplingReport.from_record(result.record))
    assert f"not closed in {unsolved['steps']} of 2000 steps, first at t = 0.00 s, by " in loop


def test_the_tracking_law_closes_its_loop_at_twenty_times_the_step_size() -> None:
    options = {"variant": "tracking", "stop_time": 60.0}
    implicit = simulate(load_scenario("dissipative-law"), algorithm="implicit", step_size=0.02, **options)
    assert implicit["plant.bit_speed"][-1] == pytest.approx(10.0, abs=1e-6)
    assert implicit.record["unsolved"]["steps"] == 0
    assert implicit.record["guards"] == {}


RUNS = [
    (name, variant.name if variant else None)
    for name in scenario_names()
    for variant in (load_scenario(name).variants or (None,))
]


ENOUGH = {
    "start-up": 45.0, "supervision": 35.0, "top-supervision": 35.0, "formation": 65.0, "mud": 65.0,
    "downhole-tool": 65.0, "string-damping": 30.0, "dissipative-law": 20.0,
}  # fmt: skip
"""When all that these do has begun [s]; plants in Python take their time."""
OTHERS = 15.0
"""As long are variants run that do what the first of the scenario does with other numbers [s]."""


@pytest.mark.slow
@pytest.mark.parametrize(("name", "variant"), RUNS)
def test_both_packagings_give_the_same_bits(name: str, variant: str | None) -> None:
    scenario = load_scenario(name)
    # all that happens in longer ones has happened by then, and plants in Python take their time
    first = variant is None or variant == scenario.variants[0].name
    stop_time = min(scenario.stop_time, ENOUGH.get(name, 100.0) if first else OTHERS)
    native = simulate(scenario, variant=variant, stop_time=stop_time)
    python = simulate(scenario, variant=variant, stop_time=stop_time, packaging="python")
    assert native.names == python.names
    for signal in native.names:
        assert native[signal].tobytes() == python[signal].tobytes(), signal
