"""Severity of stick-slip over a map: its numbers, its edges against theory, and its pictures."""

from __future__ import annotations

import json
import math
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from cosim import InputError, simulate, sweep
from cosim.drilling.map_figure import cell_edges, draw_maps
from cosim.drilling.mathematics import DrillstringParameters, equilibria, stability_boundary
from cosim.drilling.oscillation import measure
from cosim.drilling.severity import QUANTITIES, SWING, Severity
from cosim.drilling.severity_map import bistable, find_folds, read_map
from cosim.progress import Progress
from cosim.sweeps.distributions import Distribution

PNG = b"\x89PNG"
LEAST, MOST, COUNT = 6.0, 20.0, 36
CELL = (MOST - LEAST) / (COUNT - 1)
WEIGHTS = [3e4, 97347.0]


@pytest.fixture(scope="module")
def branches(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Any]:
    """Return sweeps of the paper's string from rest, up and down."""
    folder = tmp_path_factory.mktemp("branches")
    grid = {"plant.Omega": f"{LEAST}:{MOST}:{COUNT}", "plant.WOB": WEIGHTS}
    return {
        branch: sweep("stick-slip", folder / f"{branch}.zarr", grid=grid, branch=branch, workers=1)
        for branch in ("rest", "up", "down")
    }


def test_numbers_are_those_of_a_run_that_is_measured_by_itself(branches: dict[str, Any]) -> None:
    point = branches["rest"].sel({"plant.Omega": 10.0, "plant.WOB": 97347.0})
    alone = measure(simulate("stick-slip"))
    assert alone is not None
    assert float(point["bit_speed_max"]) == pytest.approx(alone.peak, rel=1e-5)
    assert float(point["bit_speed_min"]) == alone.minimum == 0.0
    # the window is 20 s, not a whole number of periods of 2.6 s
    assert float(point["ssi"]) == pytest.approx(alone.ssi, rel=0.05)
    assert float(point["stuck_fraction"]) == pytest.approx(alone.stuck_fraction, abs=0.03)
    assert float(point["period"]) == pytest.approx(alone.period, rel=1e-4)


def test_the_swing_of_the_torque_is_that_of_a_finely_recorded_run(branches: dict[str, Any]) -> None:
    torque = simulate("stick-slip")["plant.top_torque"][-2000:]
    point = branches["rest"].sel({"plant.Omega": 10.0, "plant.WOB": 97347.0})
    assert float(point["torque_swing"]) == pytest.approx(np.ptp(torque), rel=0.02)


def unstable_edge(found: Any, weight: float) -> float:
    """Return the greatest drive speed at which the bit swings, and half a cell [rad/s]."""
    at = found.sel({"plant.WOB": weight})
    swings = (at["bit_speed_max"] - at["bit_speed_min"]).values > SWING
    speeds = at["plant.Omega"].values
    last = int(np.flatnonzero(swings)[-1]) if swings.any() else -1
    return float(speeds[last]) + 0.5 * CELL if last >= 0 else -math.inf


def test_steady_rotation_continued_down_ends_at_the_linear_threshold(branches: dict[str, Any]) -> None:
    threshold = float(stability_boundary(DrillstringParameters(), [97347.0])[0])
    assert abs(unstable_edge(branches["down"], 97347.0) - threshold) <= CELL
    # at 30 kN it is below the map
    assert float(stability_boundary(DrillstringParameters(), [3e4])[0]) < LEAST
    assert unstable_edge(branches["down"], 3e4) == -math.inf


def test_stick_slip_continued_up_ends_at_the_fold_of_the_cycles(branches: dict[str, Any]) -> None:
    # models.theory.cycle.bistability.bistable_omegas; 97347 N takes it 8 s
    assert abs(unstable_edge(branches["up"], 97347.0) - 17.4624) <= CELL


def test_lines_that_go_down_begin_in_steady_rotation(branches: dict[str, Any]) -> None:
    first = branches["down"].sel({"plant.Omega": MOST})
    for weight in WEIGHTS:
        speed = equilibria(DrillstringParameters(), MOST, weight)[-1].speed
        for name in ("bit_speed_min", "bit_speed_max"):
            assert float(first[name].sel({"plant.WOB": weight})) == pytest.approx(speed, rel=1e-6)


def columns(**changes: Any) -> dict[str, np.ndarray]:
    """Return a bit that turns steadily at 5 rad/s for 20 s, and changes of it."""
    time = np.linspace(80.0, 100.0, 201)
    still = np.zeros(time.size)
    given = {
        "bit_speed_min": still + 5.0, "bit_speed_max": still + 5.0, "bit_angle": 5.0 * time, "stuck_time": still,
        "last_stop_time": still, "last_release_time": still, "slip_count": still, "bit_stuck": still,
        "top_torque": still,
    }  # fmt: skip
    return {f"plant.{name}": values for name, values in (given | changes).items()}


def found_of(**changes: Any) -> dict[str, float]:
    numbers = Severity().of(np.linspace(80.0, 100.0, 201), columns(**changes))
    return dict(zip((each.name for each in QUANTITIES), numbers, strict=True))


def test_a_bit_that_turns_steadily_has_no_severity() -> None:
    found = found_of()
    assert math.isnan(found.pop("period"))
    assert found == {"ssi": 0.0, "stuck_fraction": 0.0, "bit_speed_min": 5.0, "bit_speed_max": 5.0, "torque_swing": 0.0}


def test_a_bit_that_stands_still_has_an_infinite_index() -> None:
    still = np.zeros(201)
    found = found_of(
        bit_angle=still, bit_speed_min=still, bit_speed_max=still, stuck_time=np.linspace(80.0, 100.0, 201)
    )
    assert found["ssi"] == math.inf
    assert found["stuck_fraction"] == pytest.approx(1.0)


def test_what_happened_before_the_window_does_not_count() -> None:
    greatest = np.full(201, 5.0)
    greatest[0] = 40.0  # since the communication point before
    assert found_of(bit_speed_max=greatest)["bit_speed_max"] == 5.0


def test_branches_disagree_between_threshold_and_fold(branches: dict[str, Any]) -> None:
    maps = [read_map(branches[branch]) for branch in ("up", "down")]
    found = bistable(maps)
    assert found is not None
    apart = found[1]
    speeds = maps[0].x[apart]
    assert speeds.size > 20
    assert speeds[0] == pytest.approx(8.345, abs=CELL)
    assert speeds[-1] == pytest.approx(17.4624, abs=CELL)
    assert apart.sum() == round((speeds[-1] - speeds[0]) / CELL) + 1


def test_maps_of_other_strings_are_not_marked_as_branches_are(tmp_path: Path, branches: dict[str, Any]) -> None:
    record = json.loads(branches["down"].attrs["record"])
    record["components"]["plant"]["parameters"]["c_b"] = 50.0
    damped = branches["down"].assign_attrs(record=json.dumps(record))
    up, down, other = (read_map(each) for each in (branches["up"], branches["down"], damped))
    assert bistable([up, other]) is None
    drawn: dict[str, str] = {}
    for name, maps in {"branches": [up, down], "strings": [up, other]}.items():
        draw_maps(tmp_path / f"{name}.svg", maps, folds=(np.array([5.4, 17.5]), np.array([2e4, 97347.0])))
        drawn[name] = (tmp_path / f"{name}.svg").read_text()
    marks, folds = "#0f9d9d", "stroke: #2f6f4f"
    assert marks in drawn["branches"]
    assert marks not in drawn["strings"]
    assert (drawn["branches"].count(folds), drawn["strings"].count(folds)) == (3, 2)  # the legend has one as well


@pytest.mark.parametrize("units", ["metric", *(pytest.param(each, marks=pytest.mark.slow) for each in ("si", "field"))])
def test_maps_are_drawn_in_units_for_people(tmp_path: Path, branches: dict[str, Any], units: str) -> None:
    maps = [read_map(found) for found in branches.values()]
    draw_maps(tmp_path / "map.png", maps, units, (np.array([5.4, 17.5]), np.array([2e4, 97347.0])))
    assert (tmp_path / "map.png").read_bytes().startswith(PNG)


@pytest.mark.slow
@pytest.mark.parametrize("quantity", [each.name for each in QUANTITIES])
def test_every_number_can_be_drawn(tmp_path: Path, branches: dict[str, Any], quantity: str) -> None:
    draw_maps(tmp_path / "map.png", [read_map(branches["down"], quantity)])
    assert (tmp_path / "map.png").read_bytes().startswith(PNG)


def test_a_difference_is_taken_point_by_point(tmp_path: Path, branches: dict[str, Any]) -> None:
    up, down = (read_map(branches[branch], "bit_speed_max") for branch in ("up", "down"))
    less = up.less(down)
    assert (less.values == up.values - down.values).all()
    assert (up.less(up).values == 0.0).all()
    draw_maps(tmp_path / "map.png", [less], difference=True)
    assert (tmp_path / "map.png").read_bytes().startswith(PNG)


def test_maps_over_other_values_are_not_compared(branches: dict[str, Any]) -> None:
    whole = read_map(branches["up"])
    part = read_map(branches["up"].isel({"plant.Omega": slice(0, 5)}))
    with pytest.raises(InputError, match=r"^the maps are over other values of plant\.Omega; expected the same"):
        whole.less(part)


def test_a_map_is_the_same_in_whatever_order_its_values_were_given(branches: dict[str, Any]) -> None:
    whole = read_map(branches["rest"])
    mixed = read_map(branches["rest"].isel({"plant.Omega": slice(None, None, -1), "plant.WOB": [1, 0]}))
    for name in ("x", "y", "values", "failed", "unstable"):
        assert np.array_equal(getattr(mixed, name), getattr(whole, name)), name


def test_cells_lie_around_their_values_and_one_alone_has_a_width() -> None:
    assert cell_edges(np.array([1.0, 2.0, 4.0])).tolist() == [0.5, 1.5, 3.0, 5.0]
    assert cell_edges(np.array([7.0])).tolist() == [6.5, 7.5]


def test_a_map_of_one_speed_is_drawn(tmp_path: Path, branches: dict[str, Any]) -> None:
    from matplotlib.image import imread

    draw_maps(tmp_path / "map.png", [read_map(branches["down"].isel({"plant.Omega": [0]}), "bit_speed_max")])
    pixels = imread(tmp_path / "map.png")[..., :3]
    height, width = pixels.shape[:2]
    cells = pixels[height // 3 : height // 2, width // 3 : width // 2]
    assert (cells < 0.99).any(axis=-1).mean() > 0.9


def test_what_is_no_map_is_refused(branches: dict[str, Any]) -> None:
    with pytest.raises(InputError, match=r"^the sweep has kept no 'sii' over .*; did you mean 'ssi'\?$"):
        read_map(branches["up"], "sii")
    with pytest.raises(InputError, match=r"^the sweep is over plant\.Omega; expected two axes of numbers for a map$"):
        read_map(branches["up"].isel({"plant.WOB": 0}))


def test_lines_of_theory_belong_to_a_string_alone(tmp_path: Path, branches: dict[str, Any]) -> None:
    assert read_map(branches["up"]).string == DrillstringParameters()
    grid = {"plant.Omega": [8.0, 10.0], "plant.L": [800.0, 1172.0]}
    other = read_map(sweep("stick-slip", tmp_path / "s.zarr", grid=grid, workers=1, stop_time=25.0))
    assert other.string is None
    assert find_folds(other)[0].size == 0


def test_folds_are_looked_for_up_to_the_end_of_the_map(
    branches: dict[str, Any], monkeypatch: pytest.MonkeyPatch
) -> None:
    asked: list[float] = []

    def fold(string: DrillstringParameters, weight: float, progress: Progress) -> SimpleNamespace:
        """Stand in for a continuation of ten seconds."""
        assert string == DrillstringParameters()
        asked.append(weight)
        progress("1 cycles", 0.5)
        if len(asked) == 2:
            raise ArithmeticError("no cycle found")
        return SimpleNamespace(fold=weight / 3000.0)

    monkeypatch.setattr("cosim.drilling.mathematics.bistable_omegas", fold, raising=False)
    told: list[float] = []
    speeds, weights = find_folds(read_map(branches["up"]), 9, lambda said, part: told.append(part))
    assert told == sorted(told)
    assert told[:2] == [0.5 / 9, 1.0 / 9]
    places = np.linspace(3e4, 97347.0, 9)
    assert asked == places[:5].tolist()  # of which the last is at 21.2 rad/s, beyond the map
    assert weights.tolist() == places[[0, 2, 3, 4]].tolist()
    assert (speeds == weights / 3000.0).all()


def test_a_map_of_samples_is_the_probability_of_stick_slip(tmp_path: Path) -> None:
    found = sweep(
        "stick-slip", tmp_path / "s.zarr", grid={"plant.Omega": [6.0, 16.0], "plant.WOB": [2e4, 97347.0]},
        samples={"plant.c_b": Distribution("uniform", {"low": 0.0, "high": 200.0})}, count=8, workers=1, stop_time=60.0,
    )  # fmt: skip
    map_ = read_map(found)
    swings = (found["bit_speed_max"] - found["bit_speed_min"]) > SWING
    stands = found["stuck_fraction"] > 0.999
    assert (map_.values == (swings | stands).mean("sample").transpose("plant.WOB", "plant.Omega").values).all()
    assert map_.values[0, 1] == 0.0
    assert map_.values[1, 0] > 0.3
    draw_maps(tmp_path / "map.png", [map_])
    assert (tmp_path / "map.png").read_bytes().startswith(PNG)
    with pytest.raises(InputError, match=r"has kept no 'ssi' over .*, sample; known: probability$"):
        read_map(found, "ssi")
