"""Progress: nothing in scripts unless asked, a bar by itself where IPython runs, and what is called instead."""

from __future__ import annotations

import pickle
import sys
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import nbformat
import pytest
from nbclient import NotebookClient

from cosim import simulate, stream, sweep
from cosim.drilling.mathematics import DrillstringParameters, stability_chart
from cosim.progress import part_shown, shown

OMEGA, WOB = ("Omega", [6.0, 12.0]), ("WOB", [5e4, 1e5])


def test_a_script_prints_nothing_that_it_was_not_told_to(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    simulate("stick-slip", stop_time=1.0)
    stream("stick-slip", tmp_path / "run", stop_time=1.0)
    sweep("stick-slip", tmp_path / "map.zarr", grid={"plant.Omega": [5.0, 6.0]}, stop_time=21.0, workers=1)
    stability_chart(DrillstringParameters(), 10.0, 9e4, OMEGA, WOB)
    assert capfd.readouterr() == ("", "")


def test_a_script_shows_progress_where_it_is_asked_for(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    simulate("stick-slip", stop_time=1.0, progress=True)
    assert "simulating stick-slip: done after" in capfd.readouterr().err
    stream("stick-slip", tmp_path / "run", stop_time=1.0, progress=True)
    assert "streaming stick-slip: done after" in capfd.readouterr().err
    grid = {"plant.Omega": [5.0, 6.0]}
    sweep("stick-slip", tmp_path / "map.zarr", grid=grid, stop_time=21.0, workers=1, progress=True)
    assert "sweeping: done after" in capfd.readouterr().err
    stability_chart(DrillstringParameters(), 10.0, 9e4, OMEGA, WOB, progress=True)  # pyright: ignore[reportArgumentType]
    out, err = capfd.readouterr()
    assert "charting stability: done after" in err
    assert out == ""


def test_what_is_called_instead_is_told_all(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    parts: list[float] = []
    simulate("stick-slip", stop_time=1.0, progress=parts.append)
    assert parts[-1] == 1.0
    rows: list[tuple[str, float]] = []
    stability_chart(DrillstringParameters(), 10.0, 9e4, OMEGA, WOB, progress=lambda *told: rows.append(told))
    assert rows == [("1 of 2 rows", 0.5), ("2 of 2 rows", 1.0)]
    assert capfd.readouterr() == ("", "")


def test_what_shows_progress_can_go_to_other_processes() -> None:
    assert pickle.loads(pickle.dumps(stability_chart)) is stability_chart


def test_a_bar_comes_by_itself_in_ipython_after_a_while(
    monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    times = iter([0.0, 1.9, 2.1, 2.15, 4.0, 5.0])
    monkeypatch.setattr("time.monotonic", lambda: next(times, 6.0))
    monkeypatch.setitem(sys.modules, "IPython", SimpleNamespace(get_ipython=object))
    with shown(False, "waiting") as told:
        assert told is None
    with shown(None, "waiting") as told:
        assert told is not None
        told("one", 0.1)  # after 1.9 s
        assert capfd.readouterr().err == ""
        told("two", 0.5)  # after 2.1 s
    assert "waiting: done after" in capfd.readouterr().err
    monkeypatch.setitem(sys.modules, "IPython", SimpleNamespace(get_ipython=lambda: None))  # imported by a script
    with part_shown(None, "waiting") as part:
        assert part is None


def test_a_bar_says_that_it_was_stopped(capfd: pytest.CaptureFixture[str]) -> None:
    def fail() -> None:
        with shown(True, "[bold]waiting\x1b[31m") as told:
            assert told is not None
            told("half", 0.5)
            raise ZeroDivisionError

    with pytest.raises(ZeroDivisionError):
        fail()
    assert "[bold]waiting\\x1b[31m: stopped after" in capfd.readouterr().err


NOTEBOOK = """
import cosim.progress
from cosim import simulate, stream, sweep
from cosim.drilling.mathematics import DrillstringParameters, stability_chart
cosim.progress.PATIENCE = 0.0
---
done = simulate("stick-slip", stop_time=5.0)
---
done = stream("stick-slip", {folder!r} + "/run", stop_time=5.0)
---
done = sweep("stick-slip", {folder!r} + "/map.zarr", grid={{"plant.Omega": [5.0, 6.0]}}, stop_time=21.0, workers=1)
---
done = stability_chart(DrillstringParameters(), 10.0, 9e4, ("Omega", [6.0, 12.0]), ("WOB", [5e4, 1e5]))
---
done = simulate("stick-slip", stop_time=5.0, progress=False)
"""


@pytest.mark.slow
def test_an_executed_notebook_shows_progress_without_a_line_of_glue(tmp_path: Path) -> None:
    notebook = nbformat.v4.new_notebook()
    cells = NOTEBOOK.format(folder=str(tmp_path)).split("---")
    notebook.cells = [nbformat.v4.new_code_cell(cell.strip()) for cell in cells]
    NotebookClient(notebook, timeout=120, kernel_name="python3").execute()
    shown: list[list[Any]] = [cell.outputs for cell in notebook.cells]
    titles = ["simulating stick-slip", "streaming stick-slip", "sweeping", "charting stability"]
    for title, outputs in zip(titles, shown[1:5], strict=True):
        (output,) = outputs
        assert output.output_type == "display_data"
        assert output.data["text/html"].startswith('<progress max="1" value="1.0000">')
        assert f"{title}: done after" in output.data["text/plain"]
    assert shown[0] == shown[5] == []
