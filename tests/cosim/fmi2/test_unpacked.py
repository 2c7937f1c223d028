"""Unpacked FMUs that are kept: lent again only as they were, to one at a time, and gone with the process."""

from __future__ import annotations

import ctypes
import multiprocessing
import os
import subprocess
import sys
from contextlib import ExitStack
from pathlib import Path

import pytest

from cosim import simulate
from cosim.fmi2.library import UNPACKED, loaded_fmu
from cosim.fmi2.locate import locate_fmu
from cosim.fmi2.model_description import read_description
from cosim.fmi2.unpacked import MOST_FOLDERS, UnpackedFmus

PLANT = locate_fmu("DrillstringNeutral", "native")

pytestmark = pytest.mark.skipif(not hasattr(os, "RTLD_NOLOAD"), reason="nothing is kept on Windows")


@pytest.fixture(autouse=True)
def _clear() -> None:
    UNPACKED.clear()


def folder_of(path: Path = PLANT) -> Path:
    """Load an FMU, unload it, and return where it was."""
    with loaded_fmu("plant", path, read_description(path)) as fmu:
        return Path(fmu.unzipDirectory)


class Archive:
    """An archive that counts how often it is unpacked."""

    def __init__(self, path: Path, content: bytes = b"an archive") -> None:
        path.write_bytes(content)
        self.path, self.times = path, 0

    def unpack(self, folder: Path) -> Path:
        self.times += 1
        (folder / "resources").mkdir()
        (folder / "library.so").write_bytes(b"no library")
        return folder / "library.so"


def test_an_fmu_that_is_loaded_again_is_not_unpacked_again() -> None:
    assert folder_of() == folder_of()


def test_one_of_the_same_content_elsewhere_is_the_same(tmp_path: Path) -> None:
    copy = tmp_path / "Other.fmu"
    copy.write_bytes(PLANT.read_bytes())
    assert folder_of(copy) == folder_of()


def test_two_at_once_have_a_folder_each() -> None:
    description = read_description(PLANT)
    with ExitStack() as stack:
        both = [stack.enter_context(loaded_fmu(name, PLANT, description)) for name in ("one", "two")]
        assert both[0].unzipDirectory != both[1].unzipDirectory


@pytest.mark.parametrize("change", ["write", "add", "remove", "replace"])
def test_a_folder_that_was_changed_is_not_lent_again(change: str, tmp_path: Path) -> None:
    cache, archive = UnpackedFmus(), Archive(tmp_path / "a.fmu")
    with cache.lent(archive.path, archive.unpack) as (folder, library):
        pass
    if change == "write":
        library.write_bytes(b"NO LIBRARY")
    elif change == "add":
        (folder / "resources" / "state.txt").write_text("of an earlier run")
    elif change == "remove":
        (folder / "resources").rmdir()
    else:
        (folder / "new").write_bytes(b"no library")
        (folder / "new").replace(library)
    with cache.lent(archive.path, archive.unpack) as (other, _):
        assert other != folder
        assert not folder.exists()
    assert archive.times == 2
    cache.clear()


def test_a_folder_that_changes_while_it_is_lent_is_removed(tmp_path: Path) -> None:
    cache, archive = UnpackedFmus(), Archive(tmp_path / "a.fmu")
    with cache.lent(archive.path, archive.unpack) as (folder, _):
        (folder / "resources" / "log.txt").write_text("said by the FMU")
    assert not folder.exists()


def test_a_folder_whose_library_stays_in_the_process_is_removed() -> None:
    with loaded_fmu("plant", PLANT, read_description(PLANT)) as fmu:
        folder = Path(fmu.unzipDirectory)
        held = ctypes.CDLL(fmu.dll._name)
    assert not folder.exists()
    assert folder_of() != folder
    del held


def test_what_fails_is_not_kept(tmp_path: Path) -> None:
    cache, archive = UnpackedFmus(), Archive(tmp_path / "a.fmu")
    with pytest.raises(ZeroDivisionError), cache.lent(archive.path, archive.unpack) as (folder, _):
        raise ZeroDivisionError
    assert not folder.exists()


def test_few_are_kept(tmp_path: Path) -> None:
    cache = UnpackedFmus()
    folders: list[Path] = []
    for number in range(MOST_FOLDERS + 3):
        archive = Archive(tmp_path / f"{number}.fmu", f"archive {number}".encode())
        with cache.lent(archive.path, archive.unpack) as (folder, _):
            folders.append(folder)
    assert [folder.exists() for folder in folders] == [False] * 3 + [True] * MOST_FOLDERS
    cache.clear()
    assert not any(folder.exists() for folder in folders)


def run_in_a_child(queue: multiprocessing.Queue[str]) -> None:
    queue.put(str(folder_of()))


@pytest.mark.skipif(not hasattr(os, "fork"), reason="there is no fork here")
@pytest.mark.filterwarnings("ignore:.*fork.*:DeprecationWarning")
def test_a_forked_process_leaves_the_folders_of_its_parent_alone() -> None:
    folder = folder_of()
    context = multiprocessing.get_context("fork")
    queue = context.Queue()
    child = context.Process(target=run_in_a_child, args=(queue,))
    child.start()
    other = queue.get(timeout=60)
    child.join()
    assert other != str(folder)
    assert folder_of() == folder


def test_nothing_is_left_when_the_process_ends(tmp_path: Path) -> None:
    code = "import cosim; cosim.simulate('stick-slip', stop_time=1.0); cosim.simulate('wob-law', stop_time=1.0)"
    environment = os.environ | {"TMPDIR": str(tmp_path)}
    subprocess.run([sys.executable, "-c", code], env=environment, check=True)
    assert list(tmp_path.iterdir()) == []


def test_a_description_is_read_anew_when_the_file_has_changed(tmp_path: Path) -> None:
    copy = tmp_path / "Changing.fmu"
    names: list[str] = []
    for model in ("WeightOnBitLaw", "DissipativeLaw"):
        copy.write_bytes(locate_fmu(model, "native").read_bytes())
        names += [read_description(copy).model_name, read_description(copy).model_name]
    assert names == ["WeightOnBitLaw"] * 2 + ["DissipativeLaw"] * 2


def test_runs_in_one_folder_after_the_other_have_the_same_bits() -> None:
    runs = [simulate("stick-slip", stop_time=5.0) for _ in range(3)]
    assert runs[0] == runs[1] == runs[2]
