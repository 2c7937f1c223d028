"""An FMU reaches its place whole, checked, or not at all."""

from __future__ import annotations

import io
import zipfile
from pathlib import Path

import pytest

from fmu_src.build import native as native_build
from fmu_src.build import packing
from fmu_src.build.description import model_description
from fmu_src.errors import BuildError
from fmu_src.schema import Model, Packaging
from tests.fmu_src.gauge import GAUGE


def files(model: Model = GAUGE) -> dict[str, bytes]:
    return {"z/last": b"z", "modelDescription.xml": model_description(model, Packaging.PYTHON, "{guid}"), "a": b"a"}


def test_an_archive_depends_on_nothing_but_its_content() -> None:
    content = files()
    turned = dict(reversed(list(content.items())))
    assert packing.archive(content) == packing.archive(turned)
    with zipfile.ZipFile(io.BytesIO(packing.archive(content))) as read:
        assert read.namelist() == ["modelDescription.xml", "a", "z/last"]
        assert {info.date_time for info in read.infolist()} == {(1980, 1, 1, 0, 0, 0)}


def test_the_guid_follows_names_and_contents() -> None:
    assert packing.guid({"a": b"1"}) == packing.guid({"a": b"1"})
    assert len({packing.guid(made) for made in ({"a": b"1"}, {"a": b"2"}, {"b": b"1"}, {"a": b"1", "b": b""})}) == 4
    assert packing.guid({})[0::37] == "{}"


def test_a_good_one_is_put_in_place(tmp_path: Path) -> None:
    target = tmp_path / "new" / "Gauge.fmu"
    packing.place(files(), target, runs_here=False)
    assert target.read_bytes() == packing.archive(files())
    assert list(target.parent.iterdir()) == [target]


def test_one_that_breaks_the_standard_leaves_the_place_as_it_was(tmp_path: Path) -> None:
    target = tmp_path / "Gauge.fmu"
    target.write_bytes(b"old")
    broken = files() | {"modelDescription.xml": files()["modelDescription.xml"].replace(b'start="1.0"', b"")}
    with pytest.raises(BuildError, match=r'(?s)breaks the FMI standard.*"rate".*no start value'):
        packing.place(broken, target)
    assert target.read_bytes() == b"old"
    assert list(tmp_path.iterdir()) == [target]


def test_one_that_does_not_run_leaves_the_place_as_it_was(tmp_path: Path) -> None:
    target = tmp_path / "Gauge.fmu"
    with pytest.raises(BuildError, match="failed its trial run"):
        packing.place(files(), target)
    assert list(tmp_path.iterdir()) == []


def test_a_folder_that_cannot_be_written_is_named(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    with pytest.raises(BuildError, match=r"cannot write .*Gauge.fmu: .*; choose another folder with --output"):
        packing.place(files(), tmp_path / "file" / "Gauge.fmu")


def test_code_that_does_not_compile_shows_the_messages_of_the_compiler() -> None:
    sources = {"Gauge.c": b'#include "broken.c"\n', "broken.c": b"int unused(void) { return 1.5 }\n"}
    with pytest.raises(BuildError, match=r"(?s)Gauge: the C code does not compile for .*broken.c:1:.*error:"):
        native_build.compile_library(GAUGE.name, sources, native_build.host_target())


@pytest.mark.parametrize(("machine", "folder"), [(("Linux", "x86_64"), "linux64"), (("Darwin", "arm64"), "darwin64")])
def test_every_host_has_a_target(machine: tuple[str, str], folder: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("platform.system", lambda: machine[0])
    monkeypatch.setattr("platform.machine", lambda: machine[1])
    assert native_build.host_target().folder == folder


def test_a_host_without_a_target_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("platform.machine", lambda: "vax")
    with pytest.raises(BuildError, match=r"no native FMU can be built on .* vax; expected one of"):
        native_build.host_target()
