"""Hostile files through the front door: each is refused in a sentence, writes nothing, and leaves the master alive."""

from __future__ import annotations

import gzip
import re
import stat
import struct
import tomllib
import zipfile
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from typer.testing import CliRunner, Result

from cosim.cli.app import app
from cosim.errors import FmuFileError
from cosim.fmi2.archive import FREE_RATIO_BYTES, MOST_BYTES, MOST_IN_MEMORY, MOST_MEMBERS, open_archive
from cosim.fmi2.xml_check import MOST_DEPTH
from tests.cosim import hostile
from tests.cosim.hostile import named, of_kind, pack

pytestmark = pytest.mark.slow

DESCRIPTION = "modelDescription.xml"
SCENARIO = """
stop_time = 0.1
step_size = 0.1

[components.guest]
fmu = "guest.fmu"
"""
Members = dict[str, bytes]
Make = Callable[[Members], bytes]


@pytest.fixture
def members(probe: Path) -> Members:
    """What is in an honest FMU; the file itself is taken away."""
    with zipfile.ZipFile(probe) as archive:
        content = {name: archive.read(name) for name in archive.namelist()}
    probe.unlink()
    return content


@pytest.fixture
def house(tmp_path: Path, no_leftovers: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A working directory below a folder in which everything is watched."""
    folder = tmp_path / "above" / "here"
    folder.mkdir(parents=True)
    (folder / "guest.toml").write_text(SCENARIO)
    monkeypatch.chdir(folder)
    return folder


def everything_below(folder: Path) -> dict[Path, tuple[int, int]]:
    return {path: (path.lstat().st_mode, path.lstat().st_size) for path in sorted(folder.rglob("*"))}


def run(*arguments: str) -> Result:
    return CliRunner().invoke(app, ["run", "guest.toml", *arguments])


def refuse(house: Path, archive: bytes, code: int = 2, arguments: tuple[str, ...] = ()) -> str:
    """Run a scenario with an FMU that must be refused, and return the sentence."""
    (house / "guest.fmu").write_bytes(archive)
    above = house.parents[1]
    before = everything_below(above)
    result = run(*arguments)
    assert result.exit_code == code, result.output
    assert "Traceback" not in result.output
    lines = result.stderr.strip().splitlines()
    assert len(lines) == 1
    assert lines[0].startswith("error: ")
    assert everything_below(above) == before
    return lines[0]


def of_description(old: str, new: str) -> Make:
    """Return what packs an FMU with a replacement in its description."""

    def make(members: Members) -> bytes:
        text = members[DESCRIPTION].decode()
        assert old in text
        return pack({**members, DESCRIPTION: text.replace(old, new).encode()})

    return make


def described_by(change: Callable[[str], bytes]) -> Make:
    """Return what packs an FMU with another description."""
    return lambda members: pack({**members, DESCRIPTION: change(members[DESCRIPTION].decode())})


def with_document_type(declarations: str, use: str) -> Make:
    """Return what packs an FMU whose description declares entities and uses one in its model name."""

    def change(text: str) -> bytes:
        head, root = text.split("?>", 1)
        root = root.replace('modelName="Probe"', f'modelName="{use}"')
        return f"{head}?><!DOCTYPE fmiModelDescription [{declarations}]>{root}".encode()

    return described_by(change)


LAUGHS = '<!ENTITY a0 "ha">' + "".join(f'<!ENTITY a{n} "{f"&a{n - 1};" * 10}">' for n in range(1, 12))
NESTED = "<a>" * (MOST_DEPTH + 1) + "</a>" * (MOST_DEPTH + 1)
DEEP = f'<VendorAnnotations><Tool name="t">{NESTED}</Tool></VendorAnnotations><ModelVariables>'

CORPUS = tomllib.loads((Path(__file__).parent / "hostile.toml").read_text(encoding="utf-8"))

NAMES = {
    **{what: (case["name"], case["said"]) for what, case in CORPUS["names"].items()},
    "too long": ("resources/" + "a/" * 3000 + "b", "has 6011 characters; expected at most 1000"),
}

KINDS = {
    "symbolic link": (stat.S_IFLNK, "resources/link is a symbolic link"),
    "character device": (stat.S_IFCHR, "resources/link is a character device"),
    "block device": (stat.S_IFBLK, "resources/link is a block device"),
    "pipe": (stat.S_IFIFO, "resources/link is a pipe"),
    "socket": (stat.S_IFSOCK, "resources/link is a socket"),
}

ARCHIVES: dict[str, tuple[Make, str]] = {
    "file behind a link": (
        lambda m: pack(m, (of_kind("resources", stat.S_IFLNK), b"/tmp"), ("resources/outside.txt", b"x")),
        "the member resources is a symbolic link",
    ),
    "two descriptions": (
        lambda m: pack(m, ("modelDescription.xmL", b"<a/>")).replace(b".xmL", b".xml"),
        "'modelDescription.xml' and 'modelDescription.xml' claim the same place",
    ),
    "names that differ in case": (
        lambda m: pack(m, ("MODELDESCRIPTION.XML", b"<a/>")),
        "'modelDescription.xml' and 'MODELDESCRIPTION.XML' claim the same place",
    ),
    "names that differ in composition": (
        lambda m: pack(m, ("resources/\xe9", b""), ("resources/e\u0301", b"")),
        "claim the same place",
    ),
    "a file that is a folder": (
        lambda m: pack(m, ("resources", b""), ("resources/a", b"")),
        "'resources' and 'resources/a' claim the same place",
    ),
    "zip bomb": (
        lambda m: pack(m, ("resources/zeros", bytes(2 * FREE_RATIO_BYTES))),
        r"it unpacks to 33\.\d MB, \d+ times its size; expected at most 200 times",
    ),
    "overlapping bomb": (
        lambda m: hostile.overlapping(m, gzip.compress(bytes(10**5)) * 3, 50),
        "the members resources/.* and resources/.* overlap",
    ),
    "too many members": (
        lambda m: pack(m, *((f"resources/{index}", b"") for index in range(MOST_MEMBERS))),
        f"it has {MOST_MEMBERS + 2} members; expected at most {MOST_MEMBERS}",
    ),
    "more than the limit": (
        lambda m: hostile.with_zip64_size("resources/a", 2 * MOST_BYTES)(
            pack(m, (hostile.zip64_entry("resources/a"), b"x"))
        ),
        r"it has 8590\.0 MB unpacked; expected at most 4295\.0 MB",
    ),
    "endless size": (
        lambda m: hostile.with_zip64_size("resources/a", 2**63 - 1)(
            pack(m, (hostile.zip64_entry("resources/a"), b"x"))
        ),
        r"it has 9223372036854\.\d MB unpacked",
    ),
    "a description without end": (
        lambda m: hostile.with_size(pack(m, compression=zipfile.ZIP_STORED), DESCRIPTION, MOST_IN_MEMORY + 1),
        r"modelDescription\.xml has 134\.2 MB unpacked|unpacks to",
    ),
    "bzip2": (
        lambda m: pack(m, compression=zipfile.ZIP_BZIP2),
        "is compressed by method 12; expected 8, deflate",
    ),
    "lzma": (lambda m: pack(m, compression=zipfile.ZIP_LZMA), "is compressed by method 14"),
    "encrypted": (lambda m: hostile.encrypted(pack(m), DESCRIPTION), "modelDescription.xml is encrypted"),
    "wrong CRC": (lambda m: hostile.with_crc(pack(m), DESCRIPTION, 1), "modelDescription.xml is damaged: Bad CRC-32"),
    "declared too small": (lambda m: hostile.with_size(pack(m), DESCRIPTION, 10), "modelDescription.xml is damaged"),
    "declared too large": (
        lambda m: hostile.with_size(pack(m), DESCRIPTION, len(m[DESCRIPTION]) + 10),
        "modelDescription.xml is damaged: it has",
    ),
    "a member in the directory": (
        lambda m: hostile.with_offset(pack(m), DESCRIPTION, len(pack(m)) - 40),
        "is damaged: there is no member at byte",
    ),
    "a member beyond the end": (lambda m: hostile.with_offset(pack(m), DESCRIPTION, 2**31), "it is damaged"),
    "two members in one place": (
        lambda m: hostile.with_offset(pack(m, ("resources/a", b"x")), "resources/a", 0),
        "overlap",
    ),
    "another name at the member": (
        lambda m: pack(m).replace(DESCRIPTION.encode(), b"modelDescriptiom.xml", 1),
        "modelDescription.xml is damaged: File name in directory .* and header .* differ",
    ),
    "truncated": (lambda m: pack(m)[:-100], "is not an FMU: it is not a zip archive"),
    "beginning cut off": (lambda m: pack(m)[100:], "it is damaged: its beginning is missing"),
    "empty": (lambda m: b"", "is not an FMU: it is not a zip archive"),
    "text": (lambda m: b"an FMU, honestly", "is not an FMU: it is not a zip archive"),
    "names in no encoding": (
        lambda m: pack(m, ("resources/\xe9", b"")).replace("\xe9".encode(), b"\xff\xff"),
        "is not an FMU: the directory of the archive is damaged: 'utf-8' codec",
    ),
    "no description": (lambda m: pack({"a": b""}), "there is no modelDescription.xml in it"),
}

DESCRIPTIONS: dict[str, tuple[Make, str]] = {
    **{name: (of_description(case["old"], case["new"]), case["said"]) for name, case in CORPUS["descriptions"].items()},
    "billion laughs": (with_document_type(LAUGHS, "&a11;"), "has a document type declaration"),
    "quadratic entities": (
        with_document_type(f'<!ENTITY a "{"x" * 50_000}">', "&a;" * 5_000),
        "has a document type declaration",
    ),
    "external entity": (with_document_type('<!ENTITY a SYSTEM "file:///etc/passwd">', ""), "document type declaration"),
    "parameter entity": (
        with_document_type('<!ENTITY % a SYSTEM "file:///etc/passwd"> %a;', "x"),
        "document type declaration",
    ),
    "nested too deep": (of_description("<ModelVariables>", DEEP), "is nested more than 100 elements deep"),
    "utf-16": (
        described_by(lambda text: text.replace("UTF-8", "UTF-16").encode("utf-16")),
        "is not in UTF-8: byte 0 is 0xff",
    ),
    "not in UTF-8": (described_by(lambda text: text.replace("Probe", "Pr\xf6be").encode("latin-1")), "0xf6"),
    "not XML": (described_by(lambda text: text.encode()[:-20]), "modelDescription.xml is not XML"),
    "another document": (
        described_by(lambda text: b'<a fmiVersion="2.0"/>'),
        "modelDescription.xml is not valid",
    ),
}


def library_of(members: Members) -> str:
    return next(name for name in members if name.startswith("binaries/"))


def with_library(content: Callable[[bytes], bytes]) -> Make:
    """Return what packs an FMU with another library."""
    return lambda members: pack({**members, library_of(members): content(members[library_of(members)])})


def without_step(library: bytes) -> bytes:
    assert b"fmi2DoStep\0" in library
    return library.replace(b"fmi2DoStep\0", b"fmi2NoStep\0")


def elf(machine: int, bits: int) -> bytes:
    """Return the header of an ELF shared object for a machine of 32 or 64 bits, and nothing after it."""
    return struct.pack("<4sBBBB8xHH", b"\x7fELF", bits // 32, 1, 1, 0, 3, machine) + bytes(100)


LIBRARIES: dict[str, tuple[Make, str]] = {
    "no library": (lambda m: pack({DESCRIPTION: m[DESCRIPTION]}), "it has binaries for none"),
    "only others": (
        lambda m: pack({DESCRIPTION: m[DESCRIPTION], "binaries/riscv64-linux/probe.so": b"x"}),
        "it has binaries for riscv64-linux",
    ),
    "a folder": (
        lambda m: pack({DESCRIPTION: m[DESCRIPTION], f"{library_of(m)}/": b""}),
        "there is no probe",
    ),
    "text": (
        with_library(lambda library: b"#!/bin/sh\ntouch outside\n"),
        r"probe\.\w+ is no library; expected one for",
    ),
    "empty": (with_library(lambda library: b""), r"probe\.\w+ is no library"),
    "another machine": (
        with_library(lambda library: elf(0xF3, 64)),
        "is a library for riscv64-linux; expected one for",
    ),
    "of 32 bits": (with_library(lambda library: elf(0x03, 32)), "is a library for x86-linux; expected one for"),
    "of another system": (with_library(lambda library: b"\xcf\xfa\xed\xfe\x07\0\0\0"), "is a library for x86-darwin"),
    "cut off": (with_library(lambda library: library[:3000]), r"is cut off after 3000 bytes|cannot be loaded"),
    "cut off early": (with_library(lambda library: library[:50]), r"is cut off after 50 bytes|cannot be loaded"),
    "without a function": (with_library(without_step), "cannot be loaded: .*fmi2DoStep"),
}


@pytest.mark.slow
@pytest.mark.parametrize(("make", "message"), LIBRARIES.values(), ids=LIBRARIES)
@pytest.mark.parametrize("isolate", [False, True])
def test_a_library_that_cannot_be_one_is_refused(
    house: Path, members: Members, make: Make, message: str, isolate: bool
) -> None:
    assert_matches(message, refuse(house, make(members), arguments=("--isolate",) if isolate else ()))


def test_a_library_of_another_description_is_refused(house: Path, members: Members) -> None:
    make = of_description('guid="{probe}"', 'guid="{another}"')
    sentence = refuse(house, make(members), code=1)
    assert sentence == "error: guest: fmi2Instantiate failed: not this time, 7"


@pytest.mark.parametrize(("name", "message"), NAMES.values(), ids=NAMES)
def test_a_name_that_leads_elsewhere_is_refused(house: Path, members: Members, name: str, message: str) -> None:
    assert_matches(message, refuse(house, pack(members, (named(name), b"outside"))))


@pytest.mark.parametrize(("mode", "message"), KINDS.values(), ids=KINDS)
def test_what_is_neither_file_nor_folder_is_refused(house: Path, members: Members, mode: int, message: str) -> None:
    assert_matches(message, refuse(house, pack(members, (of_kind("resources/link", mode), b"../../outside"))))


@pytest.mark.parametrize(("make", "message"), ARCHIVES.values(), ids=ARCHIVES)
def test_an_archive_that_lies_or_is_damaged_is_refused(house: Path, members: Members, make: Make, message: str) -> None:
    assert_matches(message, refuse(house, make(members)))


@pytest.mark.parametrize(("make", "message"), DESCRIPTIONS.values(), ids=DESCRIPTIONS)
def test_a_description_that_cannot_be_trusted_is_refused(
    house: Path, members: Members, make: Make, message: str
) -> None:
    assert_matches(message, refuse(house, make(members)))


STRUCTURE = """<?xml version="1.0" encoding="UTF-8"?>
<ssd:SystemStructureDescription xmlns:ssd="http://ssp-standard.org/SSP1/SystemStructureDescription"
    version="1.0" name="guests"><ssd:System name="guests"><ssd:Elements>
  <ssd:Component name="guest" type="application/x-fmu-sharedlibrary" source="resources/guest.fmu"/>
</ssd:Elements></ssd:System></ssd:SystemStructureDescription>"""

SYSTEMS: dict[str, tuple[Make, str]] = {
    "parent": (lambda m: system(m, (named("../outside.txt"), b"")), "leads out of the archive"),
    "link": (lambda m: system(m, (of_kind("resources/link", stat.S_IFLNK), b"/")), "is a symbolic link"),
    "zip bomb": (lambda m: system(m, ("zeros", bytes(2 * FREE_RATIO_BYTES))), "times its size"),
    "two structures": (lambda m: system(m, ("systemstructure.ssd", b"")), "claim the same place"),
    "truncated": (lambda m: system(m)[:-60], "is not an SSP file: it is not a zip archive"),
    "laughs": (
        lambda m: system(m, structure=STRUCTURE.replace("?>", f"?><!DOCTYPE a [{LAUGHS}]>").replace("guests", "&a11;")),
        "SystemStructure.ssd has a document type declaration",
    ),
    "nested too deep": (
        lambda m: system(m, structure=STRUCTURE.replace("<ssd:System ", f"{NESTED}<ssd:System ")),
        "SystemStructure.ssd is nested more than 100 elements deep",
    ),
    "a source elsewhere": (
        lambda m: system(m, structure=STRUCTURE.replace("resources/guest.fmu", "../../guest.fmu")),
        r"the source of component guest is '\.\./\.\./guest\.fmu'; expected a path within the archive",
    ),
    "a source on the net": (
        lambda m: system(m, structure=STRUCTURE.replace("resources/guest.fmu", "http://localhost:9/guest.fmu")),
        "expected a path within the archive",
    ),
    "an FMU that is hostile": (
        lambda m: system({**m, DESCRIPTION: b"<!DOCTYPE a []>" + m[DESCRIPTION]}),
        "modelDescription.xml",
    ),
    "an FMU that is a bomb": (lambda m: system({**m, "zeros": bytes(2 * FREE_RATIO_BYTES)}), "times its size"),
}


def system(members: Members, *more: hostile.Entry, structure: str = STRUCTURE) -> bytes:
    """Pack a system of one FMU."""
    return pack({"SystemStructure.ssd": structure.encode(), "resources/guest.fmu": pack(members)}, *more)


@pytest.mark.parametrize(("make", "message"), SYSTEMS.values(), ids=SYSTEMS)
def test_a_system_that_cannot_be_trusted_is_refused(house: Path, members: Members, make: Make, message: str) -> None:
    (house / "guest.ssp").write_bytes(make(members))
    before = everything_below(house.parents[1])
    arguments = ["run", "guest.ssp", "--stop-time", "0.1", "--step-size", "0.1"]
    result = CliRunner().invoke(app, arguments)
    assert result.exit_code == 2, result.output
    assert len(result.stderr.strip().splitlines()) == 1
    assert re.search(message, result.stderr), result.stderr
    assert everything_below(house.parents[1]) == before
    (house / "guest.ssp").write_bytes(system(members))
    assert CliRunner().invoke(app, arguments).exit_code == 0


def test_what_a_file_says_does_not_act_upon_the_terminal(house: Path, members: Members) -> None:
    make = of_description('name="gain"', 'name="\x9b2J\u202e"')
    (house / "guest.fmu").write_bytes(make(members))
    result = run("--set", "guest.gain=1")
    assert result.exit_code == 2
    assert r"\x9b2J\u202e" in result.stderr
    assert "\x9b" not in result.stderr


def test_an_archive_within_an_archive_stays_packed(house: Path, members: Members) -> None:
    bomb = pack({"zeros": bytes(10 * FREE_RATIO_BYTES)})
    (house / "guest.fmu").write_bytes(pack(members, ("resources/bomb.zip", bomb)))
    assert run().exit_code == 0
    assert (house / "runs" / "guest" / "trajectory.csv").is_file()


def test_another_name_in_an_extra_field_leads_nowhere(house: Path, members: Members) -> None:
    entry = hostile.with_unicode_name("resources/a", "../../outside.txt")
    (house / "guest.fmu").write_bytes(pack(members, (entry, b"outside")))
    assert run().exit_code in (0, 2)  # readers since Python 3.13 see the other name, and it is refused
    assert {path.name for path in house.iterdir()} <= {"guest.fmu", "guest.toml", "runs"}
    assert [path.name for path in house.parent.iterdir()] == ["here"]


def test_the_master_goes_on_after_a_refusal(house: Path, members: Members) -> None:
    refuse(house, b"")
    (house / "guest.fmu").write_bytes(pack(members))
    assert run().exit_code == 0


@settings(max_examples=200, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(data=st.data())
def test_changed_bytes_cause_no_error_but_a_refusal(
    tmp_path_factory: pytest.TempPathFactory, data: st.DataObject
) -> None:
    small = {DESCRIPTION: b"<fmiModelDescription/>", "resources/table.csv": b"time,u\n0,1\n" * 20}
    archive = bytearray(pack(small))
    for _ in range(data.draw(st.integers(1, 4))):
        archive[data.draw(st.integers(0, len(archive) - 1))] = data.draw(st.integers(0, 255))
    folder = tmp_path_factory.mktemp("changed")
    end = data.draw(st.sampled_from([len(archive), len(archive) // 2, len(archive) - 10]))
    (folder / "changed.fmu").write_bytes(archive[:end])
    (folder / "unpacked").mkdir()
    with suppress(FmuFileError), open_archive(folder / "changed.fmu") as opened:
        opened.unpack(folder / "unpacked")
    assert {path.name for path in folder.iterdir()} == {"changed.fmu", "unpacked"}


def assert_matches(pattern: str, sentence: str) -> None:
    assert re.search(pattern, sentence), sentence
    assert "guest.fmu" in sentence
