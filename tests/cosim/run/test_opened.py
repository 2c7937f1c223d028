"""Finished runs opened again: the results that they were, or a sentence."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import nbformat
import numpy as np
import pytest
from nbclient import NotebookClient

from cosim import InputError, Result, RunOptions, load_scenario, open_run, open_variants, simulate
from cosim.run.job import Job, run_job
from cosim.run.options import Streaming
from cosim.run.report import write_content
from tests.cosim.run.jobs import nothing, sketch, small

pytestmark = pytest.mark.slow

SHORT = RunOptions(stop_time=2.0)


@pytest.fixture(autouse=True)
def _quick(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("cosim.drilling.reporting.draw", sketch)


def run(folder: Path, scenario: str = "stick-slip", streaming: Streaming | None = None, **options: Any) -> Path:
    run_job(Job(load_scenario(scenario), RunOptions(**{"stop_time": 2.0, **options}), (), streaming), folder, nothing)
    return folder


@pytest.mark.parametrize("streaming", [None, Streaming(), Streaming(csv=True)], ids=["memory", "zarr", "csv"])
def test_a_run_opened_again_is_the_result_to_the_bit(streaming: Streaming | None, tmp_path: Path) -> None:
    opened, whole = open_run(run(tmp_path / "run", streaming=streaming)), simulate("stick-slip", stop_time=2.0)
    assert set(opened.names) == set(whole.names)
    assert opened.time.tobytes() == whole.time.tobytes()
    for name in whole.names:
        assert opened[name].dtype == whole[name].dtype, name
        assert opened[name].tobytes() == whole[name].tobytes(), name
    assert opened.units["plant.bit_speed"] == "rad/s"
    assert opened.record["components"]["plant"]["model"] == "DrillstringNeutral"
    assert opened.record["measures"]["component"] == "plant"
    assert "stick-slip" in repr(opened)


def test_strings_are_read_back_as_they_were(tmp_path: Path) -> None:
    folder = run(tmp_path / "run", step_size=1.0)
    texts = {"plant.text": np.array(["", 'a, "b"', "c\nd"], dtype=object), "plant,\n.n": np.array([1, 2, 3], np.int32)}
    whole = Result(np.array([0.0, 1.0, 2.0]), texts, dict.fromkeys(texts, ""))
    whole.to_csv(folder / "trajectory.csv")
    content = json.loads((folder / "manifest.json").read_text())
    content["variants"][0] |= {"units": dict(whole.units), "types": {"plant.text": "object"}}
    write_content(folder, {name: value for name, value in content.items() if name not in ("sha256", "format")})
    assert open_run(folder) == whole


def test_variants_are_opened_by_name(tmp_path: Path) -> None:
    folder = run(tmp_path / "run", "bit-damping")
    names = [variant.name for variant in load_scenario("bit-damping").variants]
    assert list(open_variants(folder)) == names
    assert open_run(folder, names[1]) == open_variants(folder)[names[1]]
    with pytest.raises(InputError, match=rf"holds the variants '{names[0]}', .*expected the name of one"):
        open_run(folder)
    with pytest.raises(InputError, match=r"holds no variant 'c_b'"):
        open_run(folder, "c_b")


def test_columns_in_several_distances_are_no_result(tmp_path: Path) -> None:
    run_job(small(tmp_path, "light"), tmp_path / "run", nothing)
    with pytest.raises(InputError, match=r"stored over time, time_10, and a result has one time axis"):
        open_run(tmp_path / "run")


def cut(folder: Path) -> None:
    path = folder / "trajectory.csv"
    path.write_bytes(path.read_bytes()[:-40])


def lose_a_row(folder: Path) -> None:
    path = folder / "trajectory.csv"
    path.write_text("".join(path.read_text().splitlines(keepends=True)[:-1]))


def empty(folder: Path) -> None:
    (folder / "trajectory.csv").write_text("")


def lead_out(folder: Path) -> None:
    content = json.loads((folder / "manifest.json").read_text())
    content["variants"][0]["trajectory"] = "../other.csv"
    del content["sha256"], content["format"]
    write_content(folder, content)


def tell_of_none(folder: Path) -> None:
    content = json.loads((folder / "manifest.json").read_text())
    del content["sha256"], content["format"]
    write_content(folder, content | {"variants": []})


def link(folder: Path) -> None:
    (folder / "trajectory.csv").rename(folder / "other.csv")
    (folder / "trajectory.csv").symlink_to(folder / "other.csv")


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (cut, r"trajectory\.csv (is not as it was written|has \d+ rows)"),
        (lose_a_row, r"trajectory\.csv has 200 rows; manifest\.json tells of 201"),
        (empty, r"trajectory\.csv is not as it was written: rows are missing"),
        (lead_out, r"manifest\.json leads out of the folder"),
        (tell_of_none, r"manifest\.json is damaged: it tells of no variant"),
        (link, r"trajectory\.csv cannot be read: trajectory\.csv is a link"),
        (lambda folder: (folder / "trajectory.csv").unlink(), r"cannot be read: No such file"),
        (lambda folder: (folder / "manifest.json").unlink(), r"holds no run; expected a folder with a manifest\.json"),
    ],
)
def test_damage_is_a_sentence(change: Any, message: str, tmp_path: Path) -> None:
    folder = run(tmp_path / "run")
    change(folder)
    with pytest.raises(InputError, match=message):
        open_run(folder)


NOTEBOOK = """
import cosim
runs = {{folder.name: cosim.open_run(folder) for folder in sorted(__import__("pathlib").Path({folder!r}).iterdir())}}
---
import xarray
peaks = xarray.concat([run.to_xarray()["plant.bit_speed"].max() for run in runs.values()], "run")
peaks.values.tolist()
---
import pandas
pandas.concat({{name: run.to_dataframe() for name, run in runs.items()}}, names=["run"]).shape
---
cosim.plot(runs, cosim.View(["plant.bit_speed"], overlay=True))
---
next(iter(runs.values()))
"""


@pytest.mark.slow
def test_33_saved_trajectories_open_in_a_notebook(tmp_path: Path) -> None:
    weights = np.linspace(3e4, 1.2e5, 33)
    for number, weight in enumerate(weights):
        run(tmp_path / "runs" / f"{number:02}", overrides={"plant.WOB": float(weight)})
    notebook = nbformat.v4.new_notebook()
    text = NOTEBOOK.format(folder=str(tmp_path / "runs"))
    notebook.cells = [nbformat.v4.new_code_cell(cell.strip()) for cell in text.split("---")]
    NotebookClient(notebook, timeout=120, kernel_name="python3").execute()
    outputs = [cell.outputs[-1].data for cell in notebook.cells[1:]]
    expected = [simulate("stick-slip", stop_time=2.0, overrides={"plant.WOB": float(each)}) for each in weights]
    assert json.loads(outputs[0]["text/plain"].replace("\n", "")) == [
        float(each["plant.bit_speed"].max()) for each in expected
    ]
    assert outputs[1]["text/plain"] == "(6633, 23)"
    assert outputs[2]["image/png"]
    assert "<table>" in outputs[3]["text/html"]
