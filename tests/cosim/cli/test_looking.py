"""`cosim plot` and `cosim info`: what there is, and figures of what was run."""

from __future__ import annotations

from pathlib import Path
from xml.etree import ElementTree

import pytest
from typer.testing import CliRunner, Result

from cosim.cli.app import app


def cosim(*arguments: object) -> Result:
    return CliRunner(env={"COLUMNS": "200"}).invoke(app, list(map(str, arguments)))


@pytest.fixture(scope="module")
def runs(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("runs")
    for name in ("lower-wob", "bit-damping"):
        done = cosim("run", name, "--stop-time", 5, "--output", folder / name)
        assert done.exit_code == 0, done.output
    return folder


@pytest.mark.parametrize("kind", ["png", "svg", "pdf"])
def test_a_finished_run_is_drawn(kind: str, runs: Path, tmp_path: Path) -> None:
    done = cosim("plot", runs / "lower-wob", "--format", kind, "--output", tmp_path / f"figure.{kind}")
    assert (done.exit_code, done.output) == (0, f"wrote {tmp_path / f'figure.{kind}'}\n")
    assert (tmp_path / f"figure.{kind}").stat().st_size > 1000


def test_runs_are_drawn_over_each_other_in_units_of_the_field(runs: Path, tmp_path: Path) -> None:
    target = tmp_path / "both.svg"
    folders = [runs / "lower-wob", runs / "bit-damping"]
    done = cosim("plot", *folders, "--overlay", "--units", "field", "--signal", "plant.top_torque", "--output", target)
    assert done.exit_code == 0, done.output
    comments = target.read_text()  # matplotlib writes texts as outlines, and beside them as comments
    assert "<!-- Top torque [kft.lbf] -->" in comments
    assert f"<!-- {folders[0]} -->" in comments
    ElementTree.parse(target)


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        (("plot", "nowhere"), "nowhere holds no run; expected a folder with a manifest.json"),
        (("plot", "lower-wob", "--signal", "plant.bit_sped"), "did you mean 'plant.bit_speed'?"),
        (("plot", "lower-wob", "--variant", "light"), "lower-wob holds no variant 'light'"),
        (("plot", "lower-wob", "--format", "gif"), "plot.gif: expected a name that ends in .png, .svg or .pdf"),
        (("plot", "lower-wob", "--format", "pdf", "--output", "a.png"), "a.png: expected a name that ends in .pdf"),
        (("plot", "lower-wob", "--from", "3", "--to", "1"), "the figure begins at 3 s and ends at 1 s"),
        (("plot", "lower-wob", "--units", "imperial"), "there are no units 'imperial'; known: field, metric, si"),
        (
            ("plot", "lower-wob", "--output", "no/where.png"),
            "no/where.png cannot be written: No such file or directory",
        ),
        (("info", "stick-slop"), "there is no FMU or scenario 'stick-slop'; did you mean 'stick-slip'?"),
        (("info", "nothing.fmu"), "nothing.fmu: there is no such file"),
    ],
)
def test_what_cannot_be_shown_is_one_sentence(
    arguments: tuple[str, ...], sentence: str, runs: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(runs)
    done = cosim(*arguments)
    assert done.exit_code == 2
    assert sentence in " ".join(done.output.split())
    assert done.output.startswith("error: ")


def test_an_fmu_is_described_by_its_variables() -> None:
    done = cosim("info", "WeightOnBitLaw")
    assert done.exit_code == 0
    (row,) = (line for line in done.output.splitlines() if line.startswith("K_w"))
    assert row.split()[:7] == ["K_w", "parameter", "tunable", "Real", "N.s/rad", "5000.0", "0"]
    assert "interpolated inputs" in done.output


def test_a_scenario_is_described_by_what_it_couples() -> None:
    done = cosim("info", "dissipative-law", "--variant", "tracking")
    assert done.exit_code == 0
    for line in (
        "  plant.top_speed -> law.top_speed",
        "algebraic loops:",
        "  plant.Omega -> plant.top_speed -> law.top_speed -> law.Omega -> plant.Omega",
    ):
        assert line in done.output.splitlines(), done.output
