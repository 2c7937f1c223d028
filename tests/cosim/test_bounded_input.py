"""Files of any size and kind where a file is expected, and text of any kind in them: bounded, and one sentence."""

from __future__ import annotations

import logging
import os
import struct
import unicodedata
import zipfile
from collections.abc import Callable
from pathlib import Path

import pytest
from rich.text import Text
from typer.testing import CliRunner

from cosim import load_scenario
from cosim.cli.app import app
from cosim.cli.terminal import SafeConsole, sentences
from cosim.errors import CosimError, FmuFileError, ScenarioError, printable, suggestion
from cosim.files import UnfitFileError, read_file, replace_file, why
from cosim.fmi2.archive import MOST_MEMBERS, open_archive
from cosim.fmi2.xml_check import MOST_TEXT, check_xml
from cosim.scenario.ssp.writing import export_ssp
from cosim.system.table_file import read_table

BASE = 'stop_time = 1.0\nstep_size = 0.1\ncomponents.plant.fmu = "DrillstringNeutral"\n'
TOML: dict[str, str] = {
    "an integer of 5000 digits": BASE.replace("1.0", "1" * 5000),
    "an integer of 4000 digits": BASE.replace("1.0", "1" * 4000),
    "an integer in base 16": BASE.replace("1.0", "0x" + "f" * 9000),
    "a parameter of 400 digits": f"{BASE}[components.plant.parameters]\nI_B = {'9' * 400}\n",
    "an input of 20 digits": f'{BASE}[inputs]\n"plant.WOB" = {"9" * 20}\n',
    "an integer in a table": f'{BASE}[inputs]\n"plant.WOB" = {{ kind = "table", points = [[0, {"9" * 999}]] }}\n',
    "depth": f"{BASE}x = {'[' * 5000}{']' * 5000}",
}


@pytest.mark.parametrize("way", TOML)
def test_a_scenario_beyond_what_toml_has_is_one_sentence(way: str, tmp_path: Path) -> None:
    path = tmp_path / "wide.toml"
    path.write_text(TOML[way])
    done = CliRunner().invoke(app, ["run", str(path), "--output", str(tmp_path / "run")])
    assert done.exit_code == 2, done.output
    assert done.stderr.count("\n") == 1
    assert len(done.stderr) < 1000
    assert not (tmp_path / "run").exists()


def devices(tmp_path: Path) -> list[Path]:
    """What never ends: a pipe that nobody writes to, and zeros."""
    os.mkfifo(tmp_path / "pipe")
    return [tmp_path / "pipe", Path("/dev/zero")]


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="there are no named pipes")
def test_what_is_no_regular_file_is_read_by_nobody(tmp_path: Path) -> None:
    for path in devices(tmp_path):
        with pytest.raises(UnfitFileError, match="is no regular file"):
            read_file(path, 10**6)
        with pytest.raises(ScenarioError, match=r"cannot be read: .* is no regular file"):
            read_table(path)
        with pytest.raises(FmuFileError, match=r"cannot be read: .* is no regular file"), open_archive(path):
            pytest.fail("it was opened")
        scenario = tmp_path / "linked.toml"
        scenario.unlink(missing_ok=True)
        scenario.symlink_to(path)
        with pytest.raises(ScenarioError, match=r"cannot be read: .* is no regular file"):
            load_scenario(scenario)


def test_a_file_is_read_up_to_its_bound(tmp_path: Path) -> None:
    path = tmp_path / "file"
    path.write_bytes(b"12345")
    assert read_file(path, 5) == b"12345"
    with pytest.raises(UnfitFileError, match=r"it has more than 4e-06 MB"):
        read_file(path, 4)
    (tmp_path / "link").symlink_to(path)
    assert read_file(tmp_path / "link", 5) == b"12345"
    with pytest.raises(UnfitFileError, match="link is a link"):
        read_file(tmp_path / "link", 5, follow=False)
    with pytest.raises(IsADirectoryError):
        read_file(tmp_path, 5)


def test_a_file_that_cannot_be_written_is_left_as_it_was(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = tmp_path / "file"
    replace_file(path, b"first")

    def full(descriptor: int) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr("os.fsync", full)
    with pytest.raises(OSError, match="No space left"):
        replace_file(path, b"second")
    assert path.read_bytes() == b"first"
    assert [entry.name for entry in tmp_path.iterdir()] == ["file"]


DOCUMENTS: dict[str, Callable[[str], str]] = {
    "attribute": lambda text: f'<a b="{text}"/>',
    "text": lambda text: f"<a>{text}</a>",
    "comment": lambda text: f"<a><!--{text}--></a>",
    "processing instruction": lambda text: f"<a><?b {text}?></a>",
    "name": lambda text: f"<{text}/>",
}


@pytest.mark.parametrize("what", DOCUMENTS)
def test_xml_with_longer_text_than_its_next_reader_takes_is_refused(what: str) -> None:
    with pytest.raises(FmuFileError, match=rf"^it has a {what} of"):
        check_xml(DOCUMENTS[what]("x" * 11_000_000).encode(), "it", FmuFileError)
    check_xml(DOCUMENTS[what]("x" * (900 if what == "name" else MOST_TEXT - 9)).encode(), "it", FmuFileError)


def directory(entries: int, declared: int) -> bytes:
    """An archive of nothing but a directory, which says it has some other number of entries."""
    entry = struct.pack("<4s4B4HL2L5H2L", b"PK\1\2", 20, 0, 20, 0, 0, 0, 0, 0, 0, 0, 0, 1, 0, 0, 0, 0, 0, 0) + b"a"
    content = entry * entries
    return content + struct.pack("<4s4H2LH", b"PK\5\6", 0, 0, declared % 2**16, declared % 2**16, len(content), 0, 0)


@pytest.mark.parametrize(
    ("entries", "message"),
    [(MOST_MEMBERS + 1, "it has 20001 members"), (600_000, "it has 600000 members"), (3_000_000, "its directory has")],
)
def test_an_archive_of_millions_of_members_is_refused_before_they_are_read(
    entries: int, message: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = tmp_path / "guest.fmu"
    path.write_bytes(directory(entries, 1))

    def fail(*given: object) -> None:
        pytest.fail("an object was made of each")

    monkeypatch.setattr(zipfile, "ZipFile", fail)
    with pytest.raises(FmuFileError, match=message), open_archive(path):
        pytest.fail("it was opened")


def test_many_values_of_no_variable_are_named_in_few_sentences(
    tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    export_ssp(load_scenario("stick-slip"), tmp_path / "a.ssp")
    more = "".join(f'<ssv:Parameter name="n{k}"><ssv:Real value="1"/></ssv:Parameter>' for k in range(30_000))
    with zipfile.ZipFile(tmp_path / "a.ssp") as old, zipfile.ZipFile(tmp_path / "b.ssp", "w") as new:
        for name in old.namelist():
            content = old.read(name)
            if name.endswith(".ssv"):
                content = content.replace(b"</ssv:Parameters>", more.encode() + b"</ssv:Parameters>")
            new.writestr(name, content)
    from cosim.scenario.ssp.reading import open_ssp

    with caplog.at_level(logging.WARNING), open_ssp(tmp_path / "b.ssp", stop_time=1.0):
        assert len(caplog.messages) < 30
        assert caplog.messages[-1] == "program: 29980 more values are ignored"


def test_a_name_is_compared_with_few_others() -> None:
    assert suggestion("bit_sped", ["bit_speed"]) == "; did you mean 'bit_speed'?"
    assert suggestion("bit_sped", [f"name{number}" for number in range(300_000)]) == ""
    assert suggestion("x" * 10**6, ["x" * 10**6 + "y"]) == ""


HOSTILE = "a\x1b]0;owned\x07b\x9b31mc\u202egnp\u2066d\u200be\x00f\ud800g"


def is_harmless(text: str) -> bool:
    kinds = {unicodedata.category(each) for each in text.replace("\n", "")}
    return kinds.isdisjoint({"Cc", "Cf", "Cs", "Co", "Cn", "Zl", "Zp"})


def test_text_is_written_out_where_it_would_act() -> None:
    assert is_harmless(printable(HOSTILE))
    assert printable(HOSTILE).startswith("a\\x1b]0;owned\\x07b\\x9b31mc\\u202egnp")
    for usual in ("Größe [µm/s]", "转速\u00a01", "two\nlines"):
        assert printable(usual) == usual


def test_a_console_shows_nothing_that_acts(capsys: pytest.CaptureFixture[str]) -> None:
    from rich.table import Table

    table = Table(HOSTILE)
    table.add_row(Text(HOSTILE, style="bold"))
    console = SafeConsole(force_terminal=False, width=200)
    for each in (HOSTILE, Text(HOSTILE), table):
        console.print(each, markup=False)
    assert is_harmless(capsys.readouterr().out)


@pytest.mark.parametrize("key", ["title", "name", "component"])
def test_text_from_files_acts_on_no_terminal(key: str, tmp_path: Path) -> None:
    hostile = HOSTILE.replace("\ud800", "").replace("\x00", "")
    written = "".join(f"\\u{ord(each):04x}" for each in hostile)
    text = {
        "title": f'title = "{written}"\n{BASE}',
        "name": f'{BASE}[inputs]\n"plant.{written}" = 1.0\n',
        "component": f'stop_time = 1.0\nstep_size = 0.1\n[components."{written}"]\nfmu = "DrillstringNeutral"\n',
    }[key]
    (tmp_path / "a[b]\x1b[31m.toml").write_text(text)
    for path in tmp_path.glob("*.toml"):
        done = CliRunner().invoke(app, ["run", str(path), "--output", str(tmp_path / "run")])
        assert done.exit_code == (2 if key == "name" else 0), done.output
        assert is_harmless(done.stdout)
        assert is_harmless(done.stderr)


@pytest.mark.parametrize("error", [OSError(), MemoryError(), CosimError()])
def test_an_error_is_never_empty(error: BaseException) -> None:
    assert why(error) == type(error).__name__


def test_an_error_without_words_is_named_by_its_kind(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(BaseException, match="1"), sentences():
        raise CosimError
    assert capsys.readouterr().err == "error: CosimError\n"
