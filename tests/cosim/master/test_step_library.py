"""The step loop's library is loaded whole and of this version, or made anew, and no place to keep it costs no run."""

from __future__ import annotations

import hashlib
import logging
from collections.abc import Generator
from pathlib import Path

import pytest

from cosim.master import compiled_loop as module
from cosim.master.compiled_loop import step_library


@pytest.fixture(autouse=True)
def _fresh() -> Generator[None]:
    step_library.cache_clear()
    yield
    step_library.cache_clear()


@pytest.fixture
def home(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setattr(module, "user_cache_path", lambda name: tmp_path / name)
    return tmp_path / "drillstring-cosim"


def kept(home: Path) -> Path:
    return next(path for path in home.iterdir() if path.suffix != ".sha256")


@pytest.mark.parametrize("damage", [b"", b"no library", None])
def test_a_damaged_library_in_the_cache_is_made_anew(home: Path, damage: bytes | None) -> None:
    assert step_library()[0] is not None
    path = kept(home)
    whole = path.read_bytes()
    path.unlink()  # the loaded one stays mapped
    path.write_bytes(bytes([whole[0] ^ 1]) + whole[1:] if damage is None else damage)
    step_library.cache_clear()
    assert step_library()[0] is not None
    assert path.read_bytes() == whole


@pytest.mark.slow  # the compiler makes its C library anew
def test_a_home_that_cannot_be_written_costs_the_cache_and_not_the_loop(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Neither the library nor what the compiler keeps for itself can be put there."""
    (tmp_path / "file").touch()
    monkeypatch.setattr(module, "user_cache_path", lambda name: tmp_path / "file" / name)
    for variable in ("HOME", "XDG_CACHE_HOME", "LOCALAPPDATA"):
        monkeypatch.setenv(variable, str(tmp_path / "file"))
    for variable in ("ZIG_GLOBAL_CACHE_DIR", "ZIG_LOCAL_CACHE_DIR"):
        monkeypatch.delenv(variable, raising=False)
    library, why = step_library()
    assert library is not None, why


def test_a_user_without_a_home_gets_the_loop_and_no_folder_named_after_the_missing_one(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def none(name: str) -> Path:
        raise RuntimeError(name)

    monkeypatch.chdir(tmp_path)
    for find in (none, lambda name: Path("~/.cache") / name):
        monkeypatch.setattr(module, "user_cache_path", find)
        step_library.cache_clear()
        library, why = step_library()
        assert library is not None, why
        assert not list(tmp_path.iterdir())


def test_the_library_that_came_with_the_package_is_used(
    home: Path, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    assert step_library()[0] is not None
    source = hashlib.sha256(Path(module.__file__).with_name("native").joinpath("step_loop.c").read_bytes()).hexdigest()
    compiled = kept(home)
    packaged = tmp_path / "built" / module.library_name(source[:16])
    packaged.parent.mkdir()
    packaged.write_bytes(compiled.read_bytes())
    packaged.with_name(f"{packaged.name}.sha256").write_text(hashlib.sha256(compiled.read_bytes()).hexdigest())
    monkeypatch.setattr(module, "PACKAGED", packaged.parent)
    monkeypatch.setattr(module, "cached_library", lambda source: pytest.fail("compiled in spite of the packaged one"))
    step_library.cache_clear()
    library, _ = step_library()
    assert library is not None
    assert library._name == str(packaged)


def test_without_the_compiler_the_way_to_get_it_is_told(
    home: Path, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    monkeypatch.setattr(module.util, "find_spec", lambda name: None)
    with caplog.at_level(logging.WARNING):
        library, why = step_library()
    assert library is None
    assert why in caplog.text
    assert 'ziglang; pip install "drillstring-cosim[build]" brings it' in why
