"""Formal flaws of model descriptions that do not touch running: said once, and the FMU is run."""

from __future__ import annotations

import logging
import os
import re
import sys
import zipfile
from collections.abc import Callable
from pathlib import Path

import pytest

from cosim import Component, Constant, Scenario, System, simulate
from cosim.check import check_fmu
from cosim.check.verdict import Verdict
from cosim.errors import FmuFileError
from cosim.fmi2.model_description import read_description

pytestmark = pytest.mark.usefixtures("no_leftovers")

FLAWS = {
    "discrete without variability": (' variability="discrete"', "", "must have variability"),
    "undefined unit": ('unit="rad"', 'unit="turns"', '"turns"'),
    "undefined unit with a display unit": ('unit="rad"', 'unit="turns" displayUnit="deg"', "turns"),
    "a start that is calculated": (
        'name="integral" valueReference="2" causality="output"><Real unit',
        'name="integral" valueReference="2" causality="output" initial="calculated"><Real start="0" unit',
        "provides a start value",
    ),
    "an input without a start": (
        'causality="input"><Real start="0" unit="rpm"',
        'causality="input"><Real unit="rpm"',
        "no start value",
    ),
}


def warnings(caplog: pytest.LogCaptureFixture) -> list[str]:
    return [each.getMessage() for each in caplog.records if "tolerated" in each.getMessage()]


def integral(probe: Path, *names: str) -> float:
    system = System(
        tuple(Component(name, probe) for name in names),
        (),
        {f"{name}.{u}": Constant(2.0) for name in names for u in "uv"},
    )
    return float(simulate(Scenario("flawed", system, stop_time=1.0, step_size=0.1))[f"{names[0]}.integral"][-1])


@pytest.mark.parametrize(("old", "new", "named"), FLAWS.values(), ids=FLAWS)
def test_a_flaw_that_does_not_touch_running_is_said_once(
    make_probe: Callable[..., Path], caplog: pytest.LogCaptureFixture, old: str, new: str, named: str
) -> None:
    probe = make_probe(replace={old: new})
    assert integral(probe, "one", "two") == pytest.approx(2.0, rel=1e-14)
    (said,) = warnings(caplog)
    assert said.startswith("probe.fmu: tolerated in modelDescription.xml: ")
    assert named in said


@pytest.mark.slow
@pytest.mark.parametrize(("old", "new", "named"), FLAWS.values(), ids=FLAWS)
def test_the_check_fails_it(make_probe: Callable[..., Path], old: str, new: str, named: str) -> None:
    report = check_fmu(make_probe(replace={old: new}), time_limit=60.0)
    assert not report.passed
    assert any(named in finding.found for finding in report.findings if finding.verdict is Verdict.FAILED)


@pytest.mark.slow
@pytest.mark.parametrize("encoding", ["ISO-8859-1", "windows-1252", "us-ascii", "Latin-1"])
def test_descriptions_in_old_encodings_are_read(
    make_probe: Callable[..., Path], caplog: pytest.LogCaptureFixture, tmp_path: Path, encoding: str
) -> None:
    name = "Probe" if encoding == "us-ascii" else "Sonde f\xfcr \xd6l"
    old = make_probe(replace={"UTF-8": encoding, 'modelName="Probe"': f'modelName="{name}"'})
    recoded = tmp_path / "recoded.fmu"
    with zipfile.ZipFile(old) as archive, zipfile.ZipFile(recoded, "w") as copy:
        for member in archive.namelist():
            content = archive.read(member)
            text = member == "modelDescription.xml"
            copy.writestr(member, content.decode("utf-8").encode(encoding) if text else content)
    assert read_description(recoded).model_name == name
    assert integral(recoded, "probe") == pytest.approx(2.0, rel=1e-14)
    assert warnings(caplog) == [f"recoded.fmu: tolerated in modelDescription.xml: it is in {encoding} instead of UTF-8"]
    assert not check_fmu(recoded).passed


def test_what_the_schema_forbids_is_refused(make_probe: Callable[..., Path]) -> None:
    with pytest.raises(FmuFileError, match=r"modelDescription\.xml is not valid"):
        read_description(make_probe(replace={'valueReference="5"': 'valueReference="-5"'}))


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ('<Real start="2"/>', '<Real start="two"/>', "'two'"),
        ('<Real start="1" min="0"', '<Real start="1" min="none"', "none"),
        ('<Boolean start="false"/>', '<Boolean start="no"/>', "no"),
    ],
)
def test_values_that_are_none_are_named(make_probe: Callable[..., Path], old: str, new: str, said: str) -> None:
    with pytest.raises(FmuFileError, match=said):
        read_description(make_probe(replace={old: new}))


def test_nothing_is_said_of_a_faultless_description(probe: Path, caplog: pytest.LogCaptureFixture) -> None:
    with caplog.at_level(logging.WARNING):
        integral(probe, "probe")
    assert warnings(caplog) == []


@pytest.mark.parametrize(("experiment", "told"), [('<DefaultExperiment tolerance="1e-4"/>', 1e-4), ("", 9.0)])
def test_an_fmu_is_told_the_tolerance_of_its_default_experiment(
    make_probe: Callable[..., Path], experiment: str, told: float
) -> None:
    probe = make_probe(replace={"  <ModelVariables>": f"  {experiment}\n  <ModelVariables>"})
    assert integral(probe, "tolerant") == pytest.approx(2.0 * told, rel=1e-14)


def repacked(path: Path, rename: Callable[[str], str], *more: str) -> Path:
    """Pack an FMU anew, its members under other names, and some more of a few bytes."""
    copy = path.with_name("repacked.fmu")
    with zipfile.ZipFile(path) as archive, zipfile.ZipFile(copy, "w") as out:
        for name in more:
            out.writestr(name, b"" if name.endswith("/") else b"more")
        for name in archive.namelist():
            out.writestr(rename(name), archive.read(name))
    return copy


@pytest.mark.parametrize("more", ["./", "resources/./table.csv", ""])
def test_a_folder_that_is_named_by_a_dot_is_where_it_is_and_is_said(
    probe: Path, caplog: pytest.LogCaptureFixture, more: str
) -> None:
    fmu = repacked(probe, str, more) if more else repacked(probe, lambda name: f"./{name}")
    assert integral(fmu, "probe") == pytest.approx(2.0, rel=1e-14)
    (said,) = warnings(caplog)
    first = f"'{more}'" if more else r"'\./modelDescription\.xml', and those of \d+ more,"
    expected = f"repacked\\.fmu: tolerated: the name of the member {first} has a part that is a dot"
    assert re.fullmatch(expected, said)


@pytest.mark.skipif(os.name == "nt", reason="Windows drops the dot")
def test_a_member_that_ends_in_a_dot_is_said_and_fails_the_check(probe: Path, caplog: pytest.LogCaptureFixture) -> None:
    fmu = repacked(probe, str, "K220LS_06_063141_01_1.", "resources/notes ")
    assert integral(fmu, "probe") == pytest.approx(2.0, rel=1e-14)
    (said,) = warnings(caplog)
    assert said == (
        "repacked.fmu: tolerated: the name of the member 'K220LS_06_063141_01_1.' has a part that ends in a dot or a "
        "space; the name of the member 'resources/notes ' has a part that ends in a dot or a space"
    )
    report = check_fmu(fmu)
    assert any("'K220LS_06_063141_01_1.'" in each.found for each in report.findings if each.verdict is Verdict.FAILED)


def test_windows_refuses_a_member_that_ends_in_a_dot(probe: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    fmu = repacked(probe, str, "resources/table.csv.")
    monkeypatch.setattr(sys, "platform", "win32")
    with pytest.raises(FmuFileError, match=r"'resources/table.csv\.' has a part that ends in a dot or a space"):
        read_description(fmu)


def test_members_that_differ_by_a_dot_claim_the_same_place(probe: Path) -> None:
    fmu = repacked(probe, str, "./modelDescription.xml")
    with pytest.raises(FmuFileError, match="claim the same place"):
        read_description(fmu)
