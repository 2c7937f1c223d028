"""The file and its description: what importers trip over is found, and named with its place."""

from __future__ import annotations

import os
import zipfile
from collections.abc import Callable
from pathlib import Path

import fmpy
import pytest

from cosim.check import Finding, Report, Verdict, check_fmu
from cosim.errors import FmuFileError
from cosim.fmi2.library import BINARY_FOLDERS, built_for, expected_for

Maker = Callable[..., Path]
HERE = BINARY_FOLDERS[fmpy.platform_tuple][0]


def failures(report: Report) -> dict[str, str]:
    return {finding.check: finding.found for finding in report.findings if finding.verdict is Verdict.FAILED}


def finding(report: Report, check: str) -> Finding:
    return next(each for each in report.findings if each.check == check)


def test_a_file_that_is_not_there_is_refused(tmp_path: Path) -> None:
    with pytest.raises(FmuFileError, match=r"nothing\.fmu: there is no such file"):
        check_fmu(tmp_path / "nothing.fmu")


def test_what_is_no_archive_fails_and_nothing_is_run(tmp_path: Path) -> None:
    path = tmp_path / "text.fmu"
    path.write_text("this is not a zip archive")
    report = check_fmu(path)
    assert set(failures(report)) == {"archive"}
    assert finding(report, "all checks").verdict is Verdict.NOT_CHECKED


def test_a_cut_archive_fails(make_suspect: Maker) -> None:
    path = make_suspect()
    path.write_bytes(path.read_bytes()[:-1000])
    assert "it is not a zip archive" in failures(check_fmu(path))["archive"]


def test_a_flipped_byte_in_a_file_fails_its_checksum(make_suspect: Maker) -> None:
    path = make_suspect()
    content = bytearray(path.read_bytes())
    content[content.index(b"<p>A suspect</p>") + 4] ^= 1
    path.write_bytes(content)
    report = check_fmu(path)
    assert failures(report)["archive"].startswith("documentation/index.html is damaged: Bad CRC-32")


@pytest.mark.parametrize("name", ["../evil.txt", "resources\\evil.txt", "resources/FAULT.txt"])
def test_members_that_importers_must_not_unpack_fail_and_nothing_is_run(make_suspect: Maker, name: str) -> None:
    report = check_fmu(make_suspect(files={name: b"evil"}))
    assert set(failures(report)) == {"archive"}
    assert repr(name) in failures(report)["archive"]
    assert finding(report, "all checks").verdict is Verdict.NOT_CHECKED


def test_an_archive_without_a_description_fails(tmp_path: Path) -> None:
    path = tmp_path / "empty.fmu"
    with zipfile.ZipFile(path, "w") as archive:
        archive.writestr("readme.txt", "nothing here")
    assert failures(check_fmu(path)) == {"archive": "there is no modelDescription.xml at its root"}


def test_text_that_is_not_xml_fails_with_its_place(make_suspect: Maker) -> None:
    found = failures(check_fmu(make_suspect(replace={"</fmiModelDescription>": "</fmiModel>"})))
    assert found == {"XML": "modelDescription.xml is not XML: mismatched tag: line 32, column 2"}


@pytest.mark.parametrize("version", ["1.0", "3.0"])
def test_another_version_of_fmi_is_said_plainly(make_suspect: Maker, version: str) -> None:
    report = check_fmu(make_suspect(replace={'fmiVersion="2.0"': f'fmiVersion="{version}"'}))
    assert failures(report) == {"kind": f"FMI version is {version}; such an FMU cannot be checked here"}
    assert finding(report, "all checks").verdict is Verdict.NOT_CHECKED


def test_an_fmu_for_model_exchange_only_is_said_plainly(make_suspect: Maker) -> None:
    report = check_fmu(make_suspect(replace={"<CoSimulation": "<ModelExchange"}))
    assert failures(report) == {"kind": "it is for model exchange only; such an FMU cannot be checked here"}


def test_a_broken_schema_fails_with_its_line_and_the_fmu_is_run_all_the_same(make_suspect: Maker) -> None:
    report = check_fmu(make_suspect(replace={'modelIdentifier="suspect"': 'modelIdentifier="suspect" canDance="true"'}))
    assert set(failures(report)) == {"schema"}
    assert failures(report)["schema"].startswith("line 5: Element 'CoSimulation', attribute 'canDance'")
    assert finding(report, "rules").verdict is Verdict.NOT_CHECKED
    assert finding(report, "run").verdict is Verdict.PASSED


def test_a_description_that_cannot_be_understood_fails_and_nothing_is_run(make_suspect: Maker) -> None:
    report = check_fmu(make_suspect(replace={'causality="parameter"': 'causality="constant"'}))
    assert set(failures(report)) == {"schema", "variables"}
    assert finding(report, "all checks").verdict is Verdict.NOT_CHECKED


def test_a_broken_rule_fails(make_suspect: Maker) -> None:
    outputs = '<Unknown index="3" dependencies=""/><Unknown index="4" dependencies="1"/>'
    found = failures(check_fmu(make_suspect(replace={outputs: '<Unknown index="4" dependencies="1"/>'})))
    assert "ModelStructure/Outputs must have exactly one entry" in found["rules"]


@pytest.mark.parametrize(
    ("old", "new", "problem"),
    [
        ('start="1" unit="m/s" min="-100"', 'start="-101" unit="m/s" min="-100"', "u: start -101 is out of its bounds"),
        ('min="0" max="10"', 'min="10" max="0"', "gain: min 10 is above max 0"),
    ],
)
def test_a_start_value_out_of_bounds_fails(make_suspect: Maker, old: str, new: str, problem: str) -> None:
    report = check_fmu(make_suspect(replace={old: new}))
    assert finding(report, "start values").found == problem
    assert not report.passed


LOCAL = '<ScalarVariable name="alias" valueReference="{}" causality="local"{}>{}</ScalarVariable></ModelVariables>'


@pytest.mark.parametrize(
    ("reference", "attributes", "kind", "found"),
    [
        (3, "", '<Real unit="m"/>', "z and alias are in m/s (= m s^-1) and m (= m)"),
        (3, "", "<Real/>", "z and alias are in m/s (= m s^-1) and no unit"),
        (1, ' variability="fixed" initial="exact"', '<Real unit="1" start="2"/>', "gain and alias start at 1 and 2"),
        (3, "", '<Real unit="m/s"/>', None),
        (2, ' variability="discrete"', "<Integer/>", None),
    ],
)
def test_aliases_with_other_units_or_starts_fail(
    make_suspect: Maker, reference: int, attributes: str, kind: str, found: str | None
) -> None:
    made = make_suspect(replace={"</ModelVariables>": LOCAL.format(reference, attributes, kind)})
    assert failures(check_fmu(made)).get("aliases") == found


def test_units_that_are_missing_or_without_base_units_are_noted(make_suspect: Maker) -> None:
    vague = make_suspect(replace={'<Unit name="m"><BaseUnit m="1"/></Unit>': '<Unit name="m"/>'})
    assert finding(check_fmu(vague), "units").found == "not in base units: m"
    bare = make_suspect(replace={'<Real unit="m"/>': "<Real/>"})
    assert finding(check_fmu(bare), "units").found == "1 of 3 have none: y"
    assert finding(check_fmu(bare), "units").verdict is Verdict.NOTED


def test_an_fmu_without_a_library_for_this_machine_fails(make_suspect: Maker) -> None:
    other = "win64" if HERE != "win64" else "linux64"
    path = make_suspect(folder="elsewhere", files={})
    report = check_fmu(path)
    assert failures(report) == {"libraries": f"none for {fmpy.platform_tuple}; for other platforms: elsewhere"}
    assert finding(report, "all checks").verdict is Verdict.NOT_CHECKED
    misplaced = failures(check_fmu(make_suspect(folder=other)))
    assert misplaced == {"libraries": f"{other} holds a library for {next(iter(expected_for(HERE)))}"}


def test_a_placeholder_instead_of_a_library_fails(make_suspect: Maker) -> None:
    pointer = {f"binaries/{HERE}/suspect{fmpy.sharedLibraryExtension}": b"version https://git-lfs.github.com/spec/v1\n"}
    assert failures(check_fmu(make_suspect(files=pointer))) == {"libraries": f"{HERE} holds a file that is no library"}


def test_declared_sources_must_be_there(make_suspect: Maker) -> None:
    claim = 'providesDirectionalDerivative="true"/>'
    declared = claim.replace("/>", '><SourceFiles><File name="all.c"/></SourceFiles></CoSimulation>')
    report = check_fmu(make_suspect(replace={claim: declared}))
    assert failures(report) == {"sources": "all.c: not in sources"}
    report = check_fmu(make_suspect(replace={claim: declared}, files={"sources/all.c": b"int x;"}))
    assert finding(report, "sources").verdict is Verdict.PASSED
    report = check_fmu(make_suspect(files={"sources/all.c": b"int x;"}))
    assert finding(report, "sources").verdict is Verdict.NOTED


def test_the_header_of_a_library_tells_its_platform() -> None:
    elf = b"\x7fELF" + bytes(14) + b"\xb7\x00"
    pe = b"MZ" + bytes(58) + (64).to_bytes(4, "little") + b"PE\0\0" + b"\x64\x86"
    mach = b"\xcf\xfa\xed\xfe" + 0x0100000C.to_bytes(4, "little")
    parts = [0x01000007, 0x0100000C]
    fat = b"\xca\xfe\xba\xbe\0\0\0\2" + b"".join(part.to_bytes(4, "big") + bytes(16) for part in parts)
    assert built_for(elf) == {"aarch64-linux"}
    assert built_for(pe) == {"x86_64-windows"}
    assert built_for(mach) == {"aarch64-darwin"}
    assert built_for(fat) == {"x86_64-darwin", "aarch64-darwin"}
    assert built_for(b"\x7fELF") == built_for(b"text") == set()


@pytest.mark.parametrize(
    ("files", "check"),
    [
        ({"binaries/win64/suspect.dll": b"nonsense", "binaries/darwin64/suspect.dylib": b"nonsense"}, "libraries"),
        ({"./": b""}, "archive"),
        pytest.param(
            {"resources/notes.": b"x"},
            "archive",
            marks=pytest.mark.skipif(os.name == "nt", reason="Windows drops dots"),
        ),
    ],
)
def test_what_does_not_keep_an_fmu_from_running_fails_and_the_fmu_is_run(
    make_suspect: Maker, files: dict[str, bytes], check: str
) -> None:
    others = {name: content for name, content in files.items() if not name.startswith(f"binaries/{HERE}/")}
    report = check_fmu(make_suspect(files=others))
    assert set(failures(report)) == {check}
    assert finding(report, "run").verdict is Verdict.PASSED
