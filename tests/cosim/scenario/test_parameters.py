"""Parameter files: what is written is read, runs and leagues take it, and what does not fit is a sentence."""

from __future__ import annotations

import json
import tomllib
from collections.abc import Callable
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from typer.testing import CliRunner, Result

from cosim import load_scenario
from cosim.cli.app import app
from cosim.errors import InputError
from cosim.league.entries import load_league
from cosim.scenario.parameters import load_parameters, write_toml

LEAST = 'fmu = "SoftTorque"\n[parameters]\nmode = "own"\nP = 512.3\n'
TWO = """
stop_time = 1.0
step_size = 0.125
[components.one]
fmu = "probe.fmu"
[components.two]
fmu = "probe.fmu"
"""

SCALARS = st.one_of(st.booleans(), st.integers(-(2**63), 2**63 - 1), st.floats(allow_nan=False), st.text())
TABLES = st.recursive(
    st.dictionaries(st.text(), SCALARS | st.lists(SCALARS, max_size=3), max_size=4),
    lambda inner: st.dictionaries(st.text(), SCALARS | inner, max_size=4),
    max_leaves=6,
)


@settings(max_examples=40)
@given(TABLES)
def test_what_is_written_is_read_to_the_last_bit(content: dict[str, object]) -> None:
    assert tomllib.loads(write_toml(content, ("A comment.",))) == content


def written(folder: Path, text: str = LEAST) -> Path:
    path = folder / "tuned.toml"
    path.write_text(text, encoding="utf-8")
    return path


def test_values_go_to_the_component_that_is_the_fmu(tmp_path: Path) -> None:
    given = load_parameters(written(tmp_path)).overrides(load_scenario("soft-torque"), "native")
    assert given == {"law.mode": "own", "law.P": 512.3}


def test_values_may_have_units(tmp_path: Path) -> None:
    path = written(tmp_path, f"{LEAST}filter_time = '80 ms'\nL = '2 km'\n")
    given = load_parameters(path).overrides(load_scenario("soft-torque"), "native")
    assert given["law.L"] == "2 km"  # read by the unit of the parameter, as with --set
    with pytest.raises(InputError, match=r"tuned\.toml: law\.K is '2 km'"):
        load_parameters(written(tmp_path, f"{LEAST}K = '2 km'\n")).overrides(load_scenario("soft-torque"), "native")


def test_a_file_is_a_law_of_a_league(tmp_path: Path) -> None:
    text = f'name = "mine"\ntitle = "My tuning"\n{LEAST}[drive]\nmode = "servo"\n[provenance]\nwhere.ever = 1\n'
    law = load_league(parameters=[written(tmp_path, text)]).laws[-1]
    assert (law.name, law.title, law.fmu) == ("mine", "My tuning", "SoftTorque")
    assert (law.parameters, law.drive) == ({"mode": "own", "P": 512.3}, {"mode": "servo"})
    assert load_league(parameters=[written(tmp_path)]).laws[-1].name == "tuned"


@pytest.fixture
def command(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Callable[..., Result]:
    monkeypatch.chdir(tmp_path)
    return lambda *arguments: CliRunner().invoke(app, arguments)


def test_a_run_takes_values_and_those_given_one_by_one_on_top(tmp_path: Path, command: Callable[..., Result]) -> None:
    written(tmp_path, f"{LEAST}K = 99.5\n")
    arguments = ("run", "soft-torque", "--variant", "impedance-matching", "--stop-time", "1", "--output", "out")
    done = command(*arguments, "--parameters", "tuned.toml", "--set", "law.K=77")
    assert done.exit_code == 0, done.output
    (variant,) = json.loads((tmp_path / "out" / "manifest.json").read_text())["variants"]
    law = (
        variant["run"]["components"]["law"]["parameters"]
        if "run" in variant
        else variant["components"]["law"]["parameters"]
    )
    assert {name: law[name] for name in ("P", "K")} == {"P": 512.3, "K": 77.0}


REFUSED = {
    "key": (f"fm = 1\n{LEAST}", "tuned.toml: unknown key 'fm'; did you mean 'fmu'?"),
    "fmu": ("[parameters]\nP = 1.0\n", "tuned.toml: 'fmu' is missing"),
    "nothing": ('fmu = "SoftTorque"\n', "tuned.toml: expected at least one value in [parameters]"),
    "name": (f"{LEAST}Q = 1.0\n", "tuned.toml: law: SoftTorque has no variable 'Q'"),
    "value": (f"{LEAST}K = 'much'\n", "tuned.toml: law.K is 'much'; expected a number"),
    "range": (
        f"{LEAST}K = -1.0\n",
        "tuned.toml: law.K is -1 N.m/rad; expected a finite number >= 0 and",
    ),
    "kind": (f"{LEAST}K = [1.0]\n", "tuned.toml: parameters.K is [1.0]; expected a number, true, false or a string"),
    "toml": ("fmu =", "tuned.toml: cannot be read"),
}


@pytest.mark.parametrize("what", REFUSED)
def test_what_does_not_fit_is_named_with_the_file_for_runs_and_leagues(what: str, tmp_path: Path) -> None:
    text, sentence = REFUSED[what]
    path = written(tmp_path, text)
    for take in (
        lambda: load_parameters(path).overrides(load_scenario("soft-torque"), "native"),
        lambda: load_league(parameters=[path]),
    ):
        with pytest.raises(InputError) as error:
            take()
        assert sentence in str(error.value)


def test_a_component_that_is_not_there_or_another_is_named(tmp_path: Path, probe: Path) -> None:
    (tmp_path / "two.toml").write_text(TWO)
    probing = f'fmu = "{probe.name}"\n[parameters]\ngain = 2.0\n'
    for name, text, sentence in (
        ("stick-slip", LEAST, "tuned.toml holds parameters of SoftTorque; stick-slip couples DrillstringNeutral"),
        ("soft-torque", f'component = "lav"\n{LEAST}', "soft-torque has no component 'lav'; did you mean 'law'?"),
        ("soft-torque", f'component = "drive"\n{LEAST}', "component 'drive' of soft-torque is TopDrive"),
        (tmp_path / "two.toml", probing, 'one and two of two are both probe; expected component = "one" in it, or'),
    ):
        with pytest.raises(InputError) as error:
            load_parameters(written(tmp_path, text)).overrides(load_scenario(name), "native")
        assert sentence in str(error.value)
    chosen = load_parameters(written(tmp_path, f'component = "two"\n{probing}'))
    assert chosen.overrides(load_scenario(tmp_path / "two.toml"), "native") == {"two.gain": 2.0}


def test_a_name_that_is_taken_and_a_file_that_is_not_there_are_named(
    tmp_path: Path, command: Callable[..., Result]
) -> None:
    written(tmp_path, f'name = "absorber"\n{LEAST}')
    taken = command("league", "--parameters", "tuned.toml")
    assert taken.exit_code == 2
    assert "tuned.toml: there is a law 'absorber' already; expected another name" in taken.output
    missing = command("run", "soft-torque", "--parameters", "none.toml")
    assert missing.exit_code == 2
    assert "error: none.toml: there is no such file" in missing.output
