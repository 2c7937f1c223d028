"""What is kept over time is what a run of its own records, and costs no bit of what is kept else."""

from __future__ import annotations

import json
import shutil
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from cosim import InputError, RunError, open_series, open_sweep, simulate, sweep
from cosim.errors import OutputError
from cosim.sweeps.design import Axis, product, sampled
from cosim.sweeps.series import Rows, Wanted, rows_of, spread
from cosim.sweeps.workers import dispatch, work, workbench
from tests.cosim.sweeps.measuring import OUTPUTS, Last
from tests.cosim.sweeps.test_points import FromRest, stepped
from tests.cosim.sweeps.test_store import content

GRID = {"plant.Omega": "4:16:21", "plant.WOB": "2e4:1e5:2"}
KEEP = ("plant.bit_speed", "plant.bit_stuck")


def run(path: Path, **changes: Any) -> Any:
    given: dict[str, Any] = {"grid": GRID, "measures": Last(), "workers": 1, "stop_time": 6.0, **changes}
    return sweep("stick-slip", path, **given)


@pytest.fixture(scope="module")
def whole(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return the folder of sweeps with series that this process has run alone, by branch, and of one without."""
    folder = tmp_path_factory.mktemp("whole")
    for branch in ("rest", "down"):
        run(folder / branch, branch=branch, keep=KEEP, keep_points=10)
    run(folder / "plain")
    return folder


def test_a_kept_series_has_the_bits_of_a_run_of_its_own(whole: Path) -> None:
    found = open_series(whole / "rest")
    assert found["plant.bit_speed"].dims == ("plant.Omega", "plant.WOB", "time")
    assert found["plant.Omega"].values.tolist() == [4.0, 7.0, 10.0, 13.0, 16.0]
    assert found["plant.WOB"].values.tolist() == [2e4, 1e5]
    assert found["plant.bit_speed"].dtype == np.float64
    assert found["plant.bit_speed"].attrs["units"] == "rad/s"
    assert (found["time"].attrs["units"], found["plant.WOB"].attrs["units"]) == ("s", "N")
    for speed in (4.0, 10.0):
        point = {"plant.Omega": speed, "plant.WOB": 1e5}
        alone = simulate("stick-slip", overrides=point, stop_time=6.0, step_size=0.1)
        assert found["time"].values.tolist() == alone.time.tolist()
        for name in KEEP:
            assert found[name].sel(point).values.tolist() == alone[name].tolist()
    assert set(found["message"].values.ravel()) == {""}


def test_numbers_do_not_know_whether_a_series_is_kept(whole: Path) -> None:
    found, plain = open_sweep(whole / "rest"), open_sweep(whole / "plain")
    for name in OUTPUTS:
        assert found[name].values.tobytes() == plain[name].values.tobytes()
    assert "series" not in plain.attrs
    assert json.loads(found.attrs["series"])["signals"] == list(KEEP)
    assert set(found.sizes) == set(plain.sizes)


@pytest.mark.parametrize("branch", ["up", "down"])
def test_continued_series_in_the_steps_of_the_scenario_are_one_long_run(tmp_path: Path, branch: str) -> None:
    speeds, grid = [9.0, 12.0], {"plant.Omega": [9.0, 12.0]}
    run(
        tmp_path / "s.zarr", grid=grid, branch=branch, measures=Last(sampling=None), step_size=0.5, stop_time=10.0,
        beginning=FromRest(), keep=KEEP, keep_every=1.0,
    )  # fmt: skip
    found = open_series(tmp_path / "s.zarr")
    assert found["time"].values.tolist() == [float(second) for second in range(1, 11)]
    order = speeds if branch == "up" else speeds[::-1]
    long = simulate(stepped("stick-slip", order, 10.0), step_size=0.5)
    for number, speed in enumerate(order):
        rows = np.searchsorted(long.time, found["time"].values + 10.0 * number)
        assert found["plant.bit_speed"].sel({"plant.Omega": speed}).values.tolist() == (
            long["plant.bit_speed"][rows].tolist()
        )


def test_a_continued_series_begins_where_the_point_before_has_ended(whole: Path) -> None:
    series, numbers = open_series(whole / "down"), open_sweep(whole / "down")
    assert float(series["time"][0]) == 0.1
    # other steps lead to where the numbers are taken: the plant's own error at the end of a point, not its bits
    ends = numbers["bit_speed"].sel({"plant.Omega": series["plant.Omega"], "plant.WOB": series["plant.WOB"]})
    assert series["plant.bit_speed"].isel(time=-1).values == pytest.approx(ends.values, abs=1e-5)
    assert float(np.abs(series["plant.bit_speed"].isel(time=0) - series["plant.bit_speed"].isel(time=-1)).max()) > 0.1


def test_of_a_coupled_system_its_own_steps_are_kept(tmp_path: Path) -> None:
    values = {"law.K_w": [3.0, 9.0]}
    sweep("wob-law", tmp_path / "s.zarr", grid=values, measures=Last(), workers=1, stop_time=6.0, keep=["law.WOB"])
    alone = simulate("wob-law", overrides={"law.K_w": 9.0}, stop_time=6.0)
    found = open_series(tmp_path / "s.zarr", {"law.K_w": 8.0})
    rows = np.searchsorted(alone.time, found["time"].values - 1e-9)
    assert found["law.WOB"].values.tolist() == alone["law.WOB"][rows].tolist()
    assert np.diff(found["time"].values) == pytest.approx(0.1)


@pytest.mark.parametrize("branch", ["rest", pytest.param("down", marks=pytest.mark.slow)])
def test_a_sweep_with_series_that_was_killed_ends_as_others_do(
    tmp_path: Path, whole: Path, branch: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(dispatch, "TARGET", 0.0)  # one by one
    path, copies = tmp_path / "s.zarr", list[Path]()

    def copy(said: str, part: float) -> None:
        if part < 1.0 and part > 0.3 * (len(copies) + 1):
            copies.append(tmp_path / f"killed-{len(copies)}")
            shutil.copytree(path, copies[-1])

    run(path, progress=copy, branch=branch, keep=KEEP, keep_points=10)
    assert content(path) == content(whole / branch)
    assert len(copies) == 3
    for killed in copies:
        run(killed, branch=branch, keep=KEEP, keep_points=10)
        assert content(killed) == content(whole / branch)


def test_threads_keep_the_same_bytes(tmp_path: Path, whole: Path) -> None:
    with ThreadPoolExecutor(2) as executor:
        run(tmp_path / "s.zarr", executor=(executor, 2), keep=KEEP, keep_points=10)
    assert content(tmp_path / "s.zarr") == content(whole / "rest")


@pytest.mark.slow
def test_processes_keep_the_same_bytes(tmp_path: Path, whole: Path) -> None:
    run(tmp_path / "s.zarr", workers=2, keep=KEEP, keep_points=10)
    assert content(tmp_path / "s.zarr") == content(whole / "rest")


def test_without_its_journal_a_store_has_the_series_of_what_it_tells_is_done(tmp_path: Path, whole: Path) -> None:
    path = tmp_path / "s.zarr"
    shutil.copytree(whole / "rest", path)
    for file in (path / "failed").glob("0.*"):
        file.unlink()
    run(path, keep=KEEP, keep_points=10)
    assert content(path) == content(whole / "rest")


def test_a_point_keeps_its_numbers_where_its_series_fails(
    tmp_path: Path, whole: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    class Failing(workbench.HeldRun):
        """Fail in all steps of a series."""

        def run(self, *given: Any) -> dict[str, Any]:
            if len(self.window) == 61:
                raise RunError("plant at t = 0.10 s: no such steps")
            return super().run(*given)

    work.leave()  # what this process has laid out for the same sweep
    monkeypatch.setattr(workbench, "HeldRun", Failing)
    run(tmp_path / "s.zarr", keep=KEEP, keep_points=10)
    found = open_series(tmp_path / "s.zarr")
    assert set(found["message"].values.ravel()) == {"plant at t = 0.10 s: no such steps"}
    assert np.isnan(found["plant.bit_speed"].values).all()
    numbers, plain = open_sweep(tmp_path / "s.zarr"), open_sweep(whole / "plain")
    assert not numbers["failed"].values.any()
    assert numbers["energy"].values.tobytes() == plain["energy"].values.tobytes()


def test_kept_points_are_spread_evenly_and_all_samples_and_components_are_kept() -> None:
    grid = [Axis("a", {"a": list(range(65))}), Axis("b", {"b": list(range(65))})]
    assert spread(product(grid, None, "rest"), 100) == ((0, 7, 14, 21, 28, 36, 43, 50, 57, 64),) * 2
    samples = sampled({"c.x": (0.0, 1.0)}, 7, "latin-hypercube", 0)
    mixed = product([Axis("c", {"c": ["one", "two"]}), grid[0], samples], None, "rest")
    assert spread(mixed, 3) == ((0, 1), (0, 32, 64), tuple(range(7)))
    assert spread(product([samples], None, "rest"), 1) == (tuple(range(7)),)
    for most in (1, 2, 5, 64, 4225, 10**9):
        kept = spread(product(grid, None, "rest"), most)
        assert 1 <= len(kept[0]) * len(kept[1]) <= most


def test_rows_are_picked_by_their_times_and_a_row_that_is_missing_is_told() -> None:
    rows = Rows(("x",), 0.1, 0, 3)
    times = np.array([0.0, 0.05, 0.1, 0.2, 0.25, 0.1 * 3, 0.4])
    assert np.asarray(rows.picked(times, {"x": 10.0 * times})).tolist() == [[0.0, 1.0, 2.0, 10.0 * (0.1 * 3)]]
    assert rows.picked(times[:3], {"x": times[:3]}) == "the run has no row 0.20 s after it began"


def test_rows_are_a_tenth_of_a_second_apart_or_as_the_steps_have_it() -> None:
    for duration, step_size, every, last in (
        (10.0, None, 0.1, 100), (0.05, None, 0.05, 1), (10.0, 0.01, 0.1, 100), (10.0, 0.03, 0.12, 83),
        (10.0, 0.5, 0.5, 20), (0.055, 0.01, 0.05, 1),
    ):  # fmt: skip
        rows = rows_of(Wanted(["x"]), duration, step_size, continued=False)
        assert (rows.every, rows.last) == (pytest.approx(every), last)


def test_rows_of_short_points_do_not_end_after_them() -> None:
    assert 3 * 0.003 > 0.009
    assert rows_of(Wanted(("a.y",)), 0.009, 0.003, continued=False) == Rows(("a.y",), 0.009, 0, 1)


@pytest.mark.parametrize(
    ("wanted", "step_size", "sentence"),
    [
        (Wanted(["x"], 0.0), None, "series are to be kept every 0 s of points of 10 s; expected less, and > 0"),
        (Wanted(["x"], 11.0), None, "series are to be kept every 11 s of points of 10 s; expected less, and > 0"),
        (Wanted(["x"], 0.25), 0.1, "series are to be kept every 0.25 s; expected a multiple of the step size, 0.1 s"),
        (
            Wanted(["x"], 1e-6),
            None,
            "series are to be kept every 1e-06 s, at 10000000 times; expected 1000000 at most",
        ),
    ],
)
def test_rows_that_cannot_be_had_are_refused(wanted: Wanted, step_size: float | None, sentence: str) -> None:
    with pytest.raises(InputError) as refused:
        rows_of(wanted, 10.0, step_size, continued=False)
    assert str(refused.value) == sentence


@pytest.mark.parametrize(
    ("changes", "sentence"),
    [
        (
            {"keep": ["plant.bit_sped"]},
            "plant.bit_sped is to be kept, and DrillstringNeutral has no output of that name that is a number; "
            "did you mean 'bit_speed'?",
        ),
        (
            {"keep": ["plnt.bit_speed"]},
            "plnt.bit_speed is to be kept: there is no such component; did you mean 'plant'?",
        ),
        (
            {"keep_every": 0.5},
            "times or points are given for series, and nothing to keep; expected --keep component.variable as well",
        ),
        ({"keep": "plant.bit_sped"}, "plant.bit_sped is to be kept, and DrillstringNeutral has no output of that name "
         "that is a number; did you mean 'bit_speed'?"),
        ({"keep": KEEP, "keep_points": 0}, "series are to be kept at 0 points; expected one at least"),
        (
            {"keep": KEEP, "tolerance": 1e-6},
            "the steps vary with the tolerance; series are kept of runs with steps of one size only",
        ),
    ],
)  # fmt: skip
def test_what_cannot_be_kept_is_refused(tmp_path: Path, changes: dict[str, Any], sentence: str) -> None:
    with pytest.raises(InputError) as refused:
        run(tmp_path / "s.zarr", **changes)
    assert str(refused.value) == sentence
    assert not (tmp_path / "s.zarr").exists()


def test_points_are_found_on_axes_in_any_order_and_samples_that_there_are_not_are_refused(tmp_path: Path) -> None:
    grid = {"plant.Omega": [12.0, 6.0, 9.0]}
    run(tmp_path / "s.zarr", grid=grid, samples={"plant.c_b": (0.01, 0.1)}, count=2, keep=KEEP)
    for asked, speed in ((6.5, 6.0), (9.5, 9.0), (99.0, 12.0)):
        assert float(open_series(tmp_path / "s.zarr", {"plant.Omega": asked})["plant.Omega"]) == speed
    with pytest.raises(InputError, match=r"^the series have no 2 of sample$"):
        open_series(tmp_path / "s.zarr", {"sample": 2})


def test_a_store_with_other_series_is_refused(tmp_path: Path, whole: Path) -> None:
    for name, changes in (("rest", {}), ("plain", {"keep": KEEP}), ("rest", {"keep": KEEP, "keep_points": 12})):
        given: dict[str, Any] = changes
        with pytest.raises(OutputError, match=r" keeps other series; expected the same sweep to go on with, or a new"):
            run(whole / name, **given)


def test_the_series_of_the_nearest_point_that_is_kept_are_found(whole: Path) -> None:
    near = open_series(whole / "rest", {"plant.Omega": 11.4, "plant.WOB": 9e4})
    assert (float(near["plant.Omega"]), float(near["plant.WOB"])) == (10.0, 1e5)
    assert near["plant.bit_speed"].dims == ("time",)
    with pytest.raises(InputError, match=r"^the series are not over 'plant\.Omga'; did you mean 'plant\.Omega'\?$"):
        open_series(whole / "rest", {"plant.Omga": 1.0})
    for wrong in ("fast", float("nan")):
        with pytest.raises(InputError, match=rf"^the series have no {wrong!r} of plant\.Omega$"):
            open_series(whole / "rest", {"plant.Omega": wrong})
    with pytest.raises(InputError, match=r"the sweep has kept nothing over time; expected one with --keep component"):
        open_series(whole / "plain")
