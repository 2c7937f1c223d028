"""What a run tells is typed, the same for all ways to run, and comes back from a manifest as it went there."""

from __future__ import annotations

import json
from dataclasses import fields, replace
from pathlib import Path
from typing import Any

import pytest

from cosim import RunOptions, load_scenario, simulate, stream
from cosim.fmi2.isolation import Limits
from cosim.run.job import Job, run_job
from cosim.run.options import OptionKeywords, Streaming
from cosim.run.report import MANIFEST, Manifest, RunReport

SHORT = RunOptions(stop_time=2.0, step_size=0.02)
WAYS: dict[str, RunOptions] = {
    "explicit": SHORT,
    "explicit with a tolerance": replace(SHORT, algorithm="gauss-seidel", tolerance=0.1),
    "implicit": replace(SHORT, algorithm="implicit", variant="tracking"),
    "implicit with a tolerance": replace(SHORT, algorithm="implicit", variant="tracking", tolerance=1e-3),
    "unsolved": replace(SHORT, algorithm="implicit", variant="printed", on_failure="explicit"),
    "isolated": replace(SHORT, isolate=["plant"], limits=Limits(30.0, 2e9)),
}


def nothing(label: str, part: float) -> None:
    """Show no progress."""


def content(folder: Path) -> dict[str, Any]:
    return json.loads((folder / MANIFEST).read_text(encoding="utf-8"))


@pytest.mark.slow
@pytest.mark.parametrize("way", WAYS)
def test_a_report_tells_all_that_a_record_does_and_nothing_else(way: str) -> None:
    record = simulate(load_scenario("dissipative-law"), options=WAYS[way]).record
    report = RunReport.from_record(record)
    assert report.record() == record
    assert list(report.record()) == list(record)
    assert (report.coupling.iterations is None) == ("iterations" not in record)
    assert report.isolated == (["plant"] if way == "isolated" else [])


@pytest.mark.slow
@pytest.mark.parametrize("way", ["explicit with a tolerance", "unsolved"])
def test_a_manifest_read_back_is_written_to_the_same_bytes(way: str, tmp_path: Path) -> None:
    job = Job(load_scenario("dissipative-law"), replace(WAYS[way], variant=None), streaming=Streaming())
    manifest = run_job(job, tmp_path / "run", nothing)
    unfinished = replace(manifest, job={"source": "dissipative-law"})
    (tmp_path / "first").mkdir()
    unfinished.write(tmp_path / "first")
    found = Manifest.read(tmp_path / "first")
    assert found is not None
    assert [variant.label for variant in found.variants] == list(job.labels)
    (tmp_path / "second").mkdir()
    found.write(tmp_path / "second")
    assert (tmp_path / "second" / MANIFEST).read_bytes() == (tmp_path / "first" / MANIFEST).read_bytes()
    assert Manifest.read(tmp_path / "run") is None, "a complete run is not gone on with"


def test_a_streamed_job_tells_what_one_in_memory_does(tmp_path: Path) -> None:
    told: dict[str, dict[str, Any]] = {}
    for name, streaming in (("memory", None), ("disk", Streaming())):
        run_job(Job(load_scenario("dissipative-law"), SHORT, streaming=streaming), tmp_path / name, nothing)
        told[name] = content(tmp_path / name)
        del told[name]["created"], told[name]["sha256"]
        for variant in told[name]["variants"]:
            del variant["timings"]
    assert told["memory"].pop("figure") == "figure.png"
    for kept, streamed in zip(told["memory"]["variants"], told["disk"]["variants"], strict=True):
        label = kept["variant"]
        assert kept.pop("trajectory") == f"{label}/trajectory.csv"
        assert streamed.pop("trajectory") == f"{label}/trajectory.zarr"
        assert streamed.pop("figure") == f"{label}/figure.png"
        for told_of_columns in ("units", "types"):
            whole = kept.pop(told_of_columns)
            assert streamed.pop(told_of_columns).items() < whole.items(), "only what is measured is kept"
    assert told["disk"] == told["memory"]


def test_what_a_job_writes_is_what_its_manifest_names(tmp_path: Path) -> None:
    for name, streaming in (("memory", None), ("disk", Streaming(csv=True))):
        job = Job(load_scenario("dissipative-law"), SHORT, streaming=streaming)
        manifest = run_job(job, tmp_path / name, nothing)
        written = {path.relative_to(tmp_path / name).as_posix() for path in (tmp_path / name).rglob("*.*")}
        assert set(manifest.files) == written


def test_keywords_are_the_options_and_go_on_top_of_them(tmp_path: Path) -> None:
    assert set(OptionKeywords.__annotations__) == {option.name for option in fields(RunOptions)}
    scenario = load_scenario("stick-slip")
    for result in (
        simulate(scenario, options=SHORT, step_size=0.5),
        simulate(scenario, stop_time=2.0, step_size=0.5),
        stream(scenario, tmp_path, options=SHORT, step_size=0.5),
    ):
        assert result.time.tolist() == [0.0, 0.5, 1.0, 1.5, 2.0]
    with pytest.raises(TypeError, match="step_sise"):
        simulate(scenario, step_sise=0.5)  # pyright: ignore[reportCallIssue]


@pytest.mark.parametrize("way", WAYS)
def test_options_come_back_from_json(way: str) -> None:
    options = replace(WAYS[way], overrides={"plant.I_B": 90.0, "law.form": "printed"})
    assert RunOptions.from_json(json.loads(json.dumps(options.to_json()))) == options
    streaming = Streaming({"*": 10, "plant.energy": 0}, csv=True, checkpoint_interval=1.5)
    assert Streaming.from_json(json.loads(json.dumps(streaming.to_json()))) == streaming
