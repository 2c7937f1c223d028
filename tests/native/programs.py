"""Compiles the driver of this folder: with the C code of an FMU under a sanitizer, or to load its library."""

from __future__ import annotations

import hashlib
import os
import shutil
import subprocess
import sys
import zipfile
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from filelock import FileLock

from fmu_src import project
from fmu_src.build import native as native_build
from fmu_src.build.header import table_header
from fmu_src.build.native import FMI_HEADERS, NATIVE, TARGETS, Target
from fmu_src.build.source_code import source_code, source_path
from fmu_src.fmus import MODELS

DRIVER = Path(__file__).parent
ROOT = DRIVER.parents[1]
BUILD = ROOT / "build" / "hardening"
FMUS = ROOT / "dist" / "native"
PACKAGES = {
    "gcc": "gcc libc6-dev",
    "clang": "clang libclang-rt-dev",
    "wine64": "wine64",
    "qemu-aarch64": "qemu-user libc6-arm64-cross",
}
SEED = int(os.environ.get("SEED", "1"))

WARNINGS = ("-std=c99", "-Wall", "-Wextra", "-Wconversion", "-Werror", "-ffp-contract=off")
_SUBJECT = ("judge.c", "laws.c", "plant.c", "subject.c", "subject_states.c", "subject_values.c")
_SHARED = ("choices.c", "operations_on_values.c", "sequence.c", "session.c", *_SUBJECT)
_WALKING = ("main.c", "walking.c", "walks.c", "walks_laws.c", "walks_plant.c")
_LINKED = ("fmi_linked.c", "allocation_wrapped.c")
_LOADED = ("fmi_loaded.c", "allocation_unseen.c")
_WRAPPED = tuple(f"-Wl,--wrap={name}" for name in ("malloc", "calloc", "realloc", "free", "fopen"))


@dataclass(frozen=True)
class Edit:
    """A defect put into the C code, to see that it is found.

    Attributes
    ----------
    file, old, new : str
        Which text of which file becomes which.
    finding : str
        A regular expression for what the driver then says.
    """

    file: str
    old: str
    new: str
    finding: str


@dataclass(frozen=True)
class Kind:
    """A way to compile the C code of an FMU together with the driver.

    Attributes
    ----------
    name : str
        Of its folder below build/.
    compiler : str
        Its command.
    flags : tuple of str
        Beside `WARNINGS`.
    mains : tuple of str
        The files that hold or stand for main.
    edit : Edit, optional
        What is changed in the C code before.
    """

    name: str
    compiler: str
    flags: tuple[str, ...]
    mains: tuple[str, ...] = _WALKING
    edit: Edit | None = None


_TRACED = ("-O1", "-g", "-fno-omit-frame-pointer")
_SOUND = ("-fsanitize=address,undefined,float-cast-overflow", "-fno-sanitize-recover=all")
ADDRESS = Kind("address", "gcc", (*_TRACED, *_SOUND))
MEMORY = Kind("memory", "clang", (*_TRACED, "-fsanitize=memory", "-fsanitize-memory-track-origins"))
THREAD = Kind("thread", "gcc", (*_TRACED, "-fsanitize=thread", "-pthread"), ("threads.c",))
FUZZ = Kind("fuzz", "clang", (*_TRACED, "-fsanitize=fuzzer", *_SOUND), ("fuzz.c",))
COVERAGE = Kind("coverage", "gcc", ("-O0", "-g", "--coverage"))


def compile_linked(model: str, kind: Kind) -> Path:
    """Compile a model's FMU and the driver into one program and return its path.

    Raises
    ------
    MissingToolError
        There is no such compiler.
    subprocess.CalledProcessError
        Its messages are on the standard error.
    """
    folder = BUILD / kind.name / model
    with _alone_in(folder):
        return _compile_linked(model, kind, folder)


def _compile_linked(model: str, kind: Kind, folder: Path) -> Path:
    code = source_code(MODELS[model]) | {"ds_table.h": table_header(MODELS[model], "{driver}").encode()}
    generated = [name for name in code if name.startswith("ds_table.")]
    for name in generated:
        (folder / name).write_bytes(code[name])
    paths = (source_path(MODELS[model], name) for name in code if name.endswith(".c"))
    hand_written = [path for path in paths if path is not None]
    if kind.edit is not None:
        text = (NATIVE / kind.edit.file).read_text()
        assert kind.edit.old in text, f"{kind.edit.file} no longer holds {kind.edit.old!r}"
        (folder / kind.edit.file).write_text(text.replace(kind.edit.old, kind.edit.new))
        hand_written = [path for path in hand_written if path.name != kind.edit.file] + [folder / kind.edit.file]
    driver = [DRIVER / name for name in (*kind.mains, *_SHARED, *_LINKED)]
    headers = [f"-I{path}" for path in (folder, project.FMUS / model, NATIVE, FMI_HEADERS, DRIVER)]
    sources = [folder / "ds_table.c", *hand_written, *driver]
    command = [find_compiler(kind.compiler), *WARNINGS, *kind.flags, *headers, *map(str, sources), *_WRAPPED, "-lm"]
    return _compile(
        command, folder / "driver", [*sources, *NATIVE.glob("*.h"), *DRIVER.glob("*.h"), *folder.glob("*.h")]
    )


def compile_loaded(model: str, target: Target) -> Path:
    """Compile the driver for another platform, with what the FMU in dist/ says of itself, and return its path."""
    folder = BUILD / target.folder / model
    with _alone_in(folder):
        return _compile_loaded(model, target, folder)


def _compile_loaded(model: str, target: Target, folder: Path) -> Path:
    with zipfile.ZipFile(FMUS / f"{model}.fmu") as fmu:
        for name in fmu.namelist():
            if name.startswith(("sources/", f"binaries/{target.folder}/")):
                _put(fmu.read(name), folder / name)
    assert library(model, target).is_file(), "dist/ holds FMUs for this platform only; build with --platform all"
    driver = [DRIVER / name for name in (*_WALKING, *_SHARED, *_LOADED)]
    sources = [folder / "sources" / "ds_table.c", *driver]
    headers = [f"-I{path}" for path in (folder / "sources", FMI_HEADERS, DRIVER)]
    zig = [sys.executable, "-m", "ziglang", "cc", "-target", target.triples[0], "-O2", "-g0", "-s"]
    libraries = [] if target.extension == ".dll" else ["-ldl", "-lm"]
    program = folder / ("driver.exe" if target.extension == ".dll" else "driver")
    command = [*zig, *WARNINGS, *headers, *map(str, sources), *libraries]
    return _compile(command, program, [*sources, *DRIVER.glob("*.h"), *(folder / "sources").glob("*.h")])


def _put(content: bytes, path: Path) -> None:
    """Leave a file with this content, and one that another process has loaded as it was.

    A library that is written over while it is loaded ends that process: qemu-user said "uncaught target signal 7 (Bus
    error)", 11 or 6 in 200 of 200 runs of this driver for Arm during which another process wrote the same bytes again,
    and in none of 200 during which it put a new file in the place of the old one.
    """
    if path.is_file() and path.read_bytes() == content:
        return
    path.parent.mkdir(parents=True, exist_ok=True)
    draft = path.with_name(f"{path.name}.draft")
    draft.write_bytes(content)
    draft.replace(path)


def library(model: str, target: Target) -> Path:
    """Return the path of the library that `compile_loaded` has taken out of the FMU."""
    return BUILD / target.folder / model / "binaries" / target.folder / f"{model}{target.extension}"


def target_named(folder: str) -> Target:
    """Return the target of a folder below binaries/."""
    return next(target for target in TARGETS if target.folder == folder)


def _alone_in(folder: Path) -> FileLock:
    """Return what keeps other processes waiting while this one compiles in a folder."""
    folder.mkdir(parents=True, exist_ok=True)
    return FileLock(folder / "lock")


def _compile(command: Sequence[str], program: Path, inputs: Sequence[Path]) -> Path:
    total = hashlib.sha256(repr(command).encode())
    for path in sorted(inputs):
        total.update(path.read_bytes())
    stamp = program.with_name(f"{program.name}.stamp")
    if not (program.is_file() and stamp.is_file() and stamp.read_text() == total.hexdigest()):
        stamp.unlink(missing_ok=True)
        run = [*command, "-o", str(program)]
        subprocess.run(run, cwd=program.parent, env=native_build.compiler_environment(), check=True)
        stamp.write_text(total.hexdigest())
    return program


def run(command: Sequence[object], folder: Path, seconds: float = 900.0) -> str:
    """Run a program in a folder and return what it prints; the test fails with what it complains of."""
    words = [str(word) for word in command]
    done = subprocess.run(
        words, cwd=folder, capture_output=True, text=True, errors="replace", timeout=seconds, check=False
    )
    assert done.returncode == 0, f"{' '.join(words)}\nended with {done.returncode}:\n{done.stdout[-500:]}{done.stderr}"
    return done.stdout


class MissingToolError(Exception):
    """A tool that not every machine has is missing; the message says how to install it."""


def find(command: str) -> str:
    """Return the path of a command, or raise MissingToolError."""
    found = shutil.which(command)
    if found is None:
        raise MissingToolError(f"{command} is missing: apt-get install {PACKAGES[command]}")
    return found


def find_compiler(command: str) -> str:
    """Return the path of a compiler that can sanitize, or raise MissingToolError."""
    if sys.platform != "linux":
        raise MissingToolError("the sanitizers are run on Linux")
    found = find(command)
    if command == "clang":  # its sanitizers are a package of their own
        runtime = subprocess.run(
            [found, "-print-runtime-dir"], capture_output=True, text=True, check=True
        ).stdout.strip()
        if not list(Path(runtime).glob("libclang_rt.fuzzer*")):
            raise MissingToolError(f"the sanitizers of {command} are missing: apt-get install {PACKAGES[command]}")
    return found
