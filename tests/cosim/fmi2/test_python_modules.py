"""FMUs that bring Python modules of one name: each computes its own model, in one run and one after the other."""

from __future__ import annotations

import logging
import subprocess
import sys
import textwrap
from collections.abc import Callable
from pathlib import Path

import pytest

from cosim import Component, Scenario, System, simulate

SLAVE = """
from pythonfmu import Fmi2Causality, Fmi2Slave, Real
{imports}

class Model(Fmi2Slave):
    def __init__(self, **kwargs):
        super().__init__(**kwargs)
        self.y = {value}
        self.register_variable(Real("y", causality=Fmi2Causality.output))

    def do_step(self, time, size):
        return True
"""

pytestmark = pytest.mark.slow

Make = Callable[..., Path]


@pytest.fixture
def make(tmp_path: Path) -> Make:
    """Build an FMU with pythonfmu from a script, and maybe a module that the script takes its value from."""

    def build(folder: str, script: str, value: float, helper: str | None = None) -> Path:
        where = tmp_path / folder
        where.mkdir()
        imports = f"from {helper} import VALUE" if helper else ""
        source = SLAVE.format(imports=imports, value="VALUE" if helper else value)
        (where / f"{script}.py").write_text(textwrap.dedent(source))
        files = []
        if helper:
            (where / f"{helper}.py").write_text(f"VALUE = {value}\n")
            files = [f"{helper}.py"]
        command = [sys.executable, "-m", "pythonfmu", "build", "-f", f"{script}.py", "-d", ".", *files]
        subprocess.run(command, cwd=where, check=True, capture_output=True)
        return where / "Model.fmu"

    return build


def values(**fmus: Path) -> list[float]:
    system = System(tuple(Component(name, path) for name, path in fmus.items()), ())
    result = simulate(Scenario("twins", system, stop_time=0.2, step_size=0.1))
    return [float(result[f"{name}.y"][-1]) for name in fmus]


def told(caplog: pytest.LogCaptureFixture) -> list[str]:
    return [each.getMessage() for each in caplog.records if "brings a Python module" in each.getMessage()]


def test_scripts_of_one_name_compute_their_own_models(make: Make, caplog: pytest.LogCaptureFixture) -> None:
    assert values(a=make("a", "twin_1", 1.0), b=make("b", "twin_1", 2.0)) == [1.0, 2.0]
    assert told(caplog) == [
        "b: Model.fmu brings a Python module 'twin_1' that differs from the one of that name in this process; "
        "it is run in a process of its own"
    ]


def test_helper_modules_of_one_name_do_as_well(make: Make, caplog: pytest.LogCaptureFixture) -> None:
    one, other = make("a", "own_1", 1.0, "shared_helper"), make("b", "own_2", 2.0, "shared_helper")
    assert values(a=one, b=other) == [1.0, 2.0]
    assert len(told(caplog)) == 1
    assert "'shared_helper'" in told(caplog)[0]


def test_so_do_runs_one_after_the_other_in_one_process(make: Make) -> None:
    assert values(a=make("a", "twin_2", 1.0)) == [1.0]
    assert values(a=make("b", "twin_2", 2.0)) == [2.0]


def test_so_does_an_fmu_whose_module_is_named_as_one_of_the_program(
    make: Make, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "programs_own.py").write_text("VALUE = 7.0\n")
    monkeypatch.syspath_prepend(tmp_path)
    import programs_own  # pyright: ignore[reportMissingImports]

    assert programs_own.VALUE == 7.0
    assert values(a=make("a", "own_3", 2.0, "programs_own")) == [2.0]


def test_the_installed_library_is_the_one_that_fmus_bring(make: Make, caplog: pytest.LogCaptureFixture) -> None:
    import pythonfmu  # pyright: ignore[reportMissingTypeStubs]

    assert pythonfmu.__file__
    assert values(a=make("a", "twin_5", 1.0)) == [1.0]
    assert told(caplog) == []


def test_equal_modules_share_the_process(make: Make, caplog: pytest.LogCaptureFixture) -> None:
    fmu = make("a", "twin_3", 1.0)
    with caplog.at_level(logging.INFO):
        assert values(a=fmu, b=fmu) == [1.0, 1.0]
    assert told(caplog) == []


def test_scripts_of_different_names_share_the_process(make: Make, caplog: pytest.LogCaptureFixture) -> None:
    assert values(a=make("a", "first_4", 1.0), b=make("b", "second_4", 2.0)) == [1.0, 2.0]
    assert told(caplog) == []
