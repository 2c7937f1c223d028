"""Results in the tools that people go on with: read back by those tools, to the bit."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pyarrow.parquet
import pytest
import scipy.io

from cosim import InputError, Result, simulate
from cosim.errors import MissingPackageError, UnknownNameError


@pytest.fixture(scope="module")
def result() -> Result:
    return simulate("stick-slip", stop_time=10.0)


@pytest.fixture
def odd() -> Result:
    """Names and values that formats trip over."""
    columns: dict[str, np.ndarray[Any, Any]] = {
        "a b.x,1": np.array([0.1, np.inf, np.nan]),
        "a_b.x_1": np.array([1, -2, 3], dtype=np.int32),
        "a_b.x.1": np.array([True, False, True]),
        "time.units": np.array([1.0, 2.0, 3.0]),
        "plant.text": np.array(["one", 'tw"o, <b>', "\x1b[31m"], dtype=object),
        f"plant.{'long' * 30}": np.array([5.0, 6.0, 7.0]),
        f"plant.{'long' * 31}": np.array([8.0, 9.0, 10.0]),
    }
    return Result(np.array([0.0, 0.5, 1.0]), columns, {"a b.x,1": "rad/s"}, {"scenario": "odd", "inputs": {"u": [1.0]}})


def test_an_xarray_dataset_has_units_and_the_account_of_the_run(result: Result) -> None:
    dataset = result.to_xarray()
    assert dataset.sizes == {"time": 1001}
    assert dataset["time"].attrs == {"units": "s"}
    for name, values in result.columns.items():
        assert dataset[name].values.dtype == values.dtype
        assert dataset[name].values.tobytes() == values.tobytes()
        assert dataset[name].attrs.get("units", "") == result.units[name]
    assert dataset.attrs["scenario"] == "stick-slip"
    assert json.loads(dataset.attrs["inputs"])["plant.WOB"] == {"kind": "constant", "value": 97347.0}
    assert dataset.sel(time=5.0)["plant.bit_speed"] == result["plant.bit_speed"][500]


def test_a_dataframe_is_over_time(result: Result) -> None:
    frame = result.to_dataframe()
    assert frame.index.name == "time"
    assert frame.index.to_numpy().tobytes() == result.time.tobytes()
    assert list(frame.columns) == list(result.names)
    assert all(frame[name].to_numpy().tobytes() == result[name].tobytes() for name in result.names)
    assert frame.attrs["units"]["plant.WOB"] == "N"


def test_parquet_is_read_back_to_the_bit_with_units(odd: Result, tmp_path: Path) -> None:
    odd.to_parquet(tmp_path / "run.parquet")
    frame = pd.read_parquet(tmp_path / "run.parquet")
    assert list(frame.columns) == list(odd)
    for name in odd:
        assert list(map(repr, frame[name].tolist())) == list(map(repr, odd[name].tolist()))
        assert odd[name].dtype == object or frame[name].dtype == odd[name].dtype
    schema = pyarrow.parquet.read_schema(tmp_path / "run.parquet")
    assert schema.field("a b.x,1").metadata == {b"unit": b"rad/s"}
    assert json.loads(schema.metadata[b"record"]) == odd.record


def test_a_mat_file_has_a_struct_for_each_component(result: Result, tmp_path: Path) -> None:
    result.to_mat(tmp_path / "run.mat")
    found = scipy.io.loadmat(tmp_path / "run.mat", simplify_cells=True)
    assert found["time"].tobytes() == result.time.tobytes()
    for name, values in result.columns.items():
        assert found["plant"][name.partition(".")[2]].tobytes() == values.tobytes(), name
    assert found["units"]["plant"]["Omega"] == "rad/s"
    assert json.loads(found["record"])["scenario"] == "stick-slip"


def test_names_that_matlab_cannot_have_are_changed_and_no_two_become_one(odd: Result, tmp_path: Path) -> None:
    odd.to_mat(tmp_path / "run.mat")
    found = scipy.io.loadmat(tmp_path / "run.mat", simplify_cells=True)
    seen: dict[str, Any] = {}
    for component, variables in found["names"].items():
        assert len(component) <= 63
        for variable, name in variables.items():
            assert len(variable) <= 63
            assert variable.isidentifier()
            seen[name] = found[component][variable]
    assert set(seen) == set(odd.columns)
    for name, values in seen.items():
        expected = odd[name] if odd[name].dtype == object else odd[name].astype(values.dtype)
        assert list(map(repr, values.tolist())) == list(map(repr, expected.tolist()))


def test_csv_takes_columns_rows_and_units_as_asked_for(result: Result, tmp_path: Path) -> None:
    names = ["plant.WOB", "plant.bit_stuck", "plant.bit_speed"]
    result.to_csv(tmp_path / "run.csv", names, decimate=250, units=True)
    lines = (tmp_path / "run.csv").read_text().splitlines()
    assert lines[0] == "time [s],plant.WOB [N],plant.bit_stuck,plant.bit_speed [rad/s]"
    assert [line.split(",")[0] for line in lines[1:]] == ["0.0", "2.5", "5.0", "7.5", "10.0"]
    read = np.loadtxt(tmp_path / "run.csv", delimiter=",", skiprows=1)
    assert read[:, 3].tobytes() == result["plant.bit_speed"][::250].tobytes()


@pytest.mark.parametrize(
    ("columns", "decimate", "message"),
    [
        (["plant.bit_sped"], 1, "'plant.bit_sped' was not recorded; did you mean 'plant.bit_speed'?"),
        ("plant.bit_speed", 1, "columns is 'plant.bit_speed'; expected a list of names"),
        (None, 0, "decimate is 0; expected a whole number >= 1, to write every row or every Nth"),
    ],
)
def test_what_csv_cannot_have_is_refused_before_anything_is_written(
    result: Result, columns: Any, decimate: int, message: str, tmp_path: Path
) -> None:
    with pytest.raises(InputError) as refused:
        result.to_csv(tmp_path / "run.csv", columns, decimate=decimate)
    assert str(refused.value) == message
    assert not (tmp_path / "run.csv").exists()


@pytest.mark.parametrize("write", [Result.to_csv, Result.to_parquet, Result.to_mat])
def test_a_file_that_cannot_be_written_is_a_sentence(result: Result, write: Any, tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"run cannot be written: No such file or directory"):
        write(result, tmp_path / "nowhere" / "run")


@pytest.mark.parametrize(
    ("module", "hand_on"),
    [("xarray", Result.to_xarray), ("pandas", Result.to_dataframe), ("pyarrow", lambda it: it.to_parquet("run"))],
)
def test_a_package_that_is_missing_is_named(
    result: Result, module: str, hand_on: Any, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setitem(__import__("sys").modules, module, None)
    with pytest.raises(MissingPackageError, match=rf"needs the package {module}; pip install .*\[data\]"):
        hand_on(result)


def test_a_notebook_shows_a_table_whose_texts_are_text(odd: Result) -> None:
    shown = odd._repr_html_()
    assert "<td>rad/s</td>" in shown
    assert "<b>" not in shown
    assert "\x1b" not in shown
    assert "Result of odd: 7 columns, 3 points, 0 s to 1 s" in shown


def test_a_table_does_not_grow_with_the_number_of_columns() -> None:
    columns = {f"part.x{number}": np.zeros(2) for number in range(5000)}
    shown = Result(np.array([0.0, 1.0]), columns, {})._repr_html_()
    assert "and 4900 more" in shown
    assert len(shown) < 50_000


def test_an_unknown_column_is_a_key_error_too(result: Result, tmp_path: Path) -> None:
    with pytest.raises(UnknownNameError):
        result.to_csv(tmp_path / "run.csv", ["nothing"])
