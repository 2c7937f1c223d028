"""Python functions are components of sweeps as well: in workers, too, as far as they can be sent there."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from cosim import InputError, open_series, simulate, sweep
from cosim.sweeps.workers.work import run_batch
from tests.cosim.sweeps.laws import stubborn, weight
from tests.cosim.sweeps.measuring import Last
from tests.cosim.sweeps.test_store import content

GRID = {"law.K_w": [1.0, 2.0, 6.0]}


def run(path: Path, law: Any, **changes: Any) -> Any:
    given: dict[str, Any] = {"grid": GRID, "measures": Last(sampling=None), "workers": 1, "stop_time": 6.0, **changes}
    return sweep("wob-law", path, components={"law": law}, **given)


def test_a_function_is_run_at_each_point(tmp_path: Path) -> None:
    found = run(tmp_path / "s.zarr", weight, keep=["law.WOB"])
    for gain in GRID["law.K_w"]:
        alone = simulate("wob-law", components={"law": weight}, overrides={"law.K_w": gain}, stop_time=6.0)
        assert float(found["bit_speed"].sel({"law.K_w": gain})) == alone["plant.bit_speed"][-1]
    series = open_series(tmp_path / "s.zarr", {"law.K_w": 6.0})["law.WOB"]
    assert float(series[-1]) == alone["law.WOB"][-1]
    run(tmp_path / "s.zarr", weight, keep=["law.WOB"])
    with pytest.raises(InputError, match=r"is of other FMUs or parameters; expected the same sweep"):
        run(tmp_path / "s.zarr", stubborn, keep=["law.WOB"])


def test_a_function_that_raises_fails_its_point(tmp_path: Path) -> None:
    found = run(tmp_path / "s.zarr", stubborn)
    assert found["failed"].values.tolist() == [0.0, 0.0, 1.0]
    assert "stubborn raised ValueError: too much" in str(found["message"].values[2])


@pytest.mark.slow
def test_processes_run_functions_to_the_same_bytes(tmp_path: Path) -> None:
    run(tmp_path / "one.zarr", weight)
    run(tmp_path / "two.zarr", weight, workers=2)
    assert content(tmp_path / "one.zarr") == content(tmp_path / "two.zarr")


def test_a_function_that_cannot_be_sent_is_refused(tmp_path: Path) -> None:
    with pytest.raises(InputError) as refused:
        run(tmp_path / "s.zarr", lambda bit_speed: 2e4, grid={"plant.Omega": [8.0, 9.0]})
    assert str(refused.value).startswith("law: the Python function <lambda> cannot be sent to workers (")
    assert str(refused.value).endswith("; expected one that is defined at the top of a module")


def test_no_fmu_takes_the_place_of_a_function(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"^law is a Python function; expected an FMU whose place others take$"):
        run(tmp_path / "s.zarr", weight, grid={"law": ["WeightOnBitLaw"]})


def test_a_function_that_a_worker_does_not_find_is_told() -> None:
    plan = b"cos.path\nno_such_law\n."  # a pickle that names a function by its module, where it is not
    with pytest.raises(ImportError, match=r"'no_such_law'.*; expected functions in a module that workers can import$"):
        run_batch("plan", plan, (), 0.0)
