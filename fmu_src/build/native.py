"""The shared libraries of a native FMU: C99 compiled by ziglang for every platform an importer may run on."""

from __future__ import annotations

import os
import platform
import shutil
import struct
import subprocess
import sys
import tempfile
from dataclasses import dataclass
from importlib import metadata
from pathlib import Path

import fmpy  # pyright: ignore[reportMissingTypeStubs]

from .. import project
from ..errors import BuildError

NATIVE = project.SOURCES / "native"
FMI_HEADERS = Path(fmpy.__file__).parent / "c-code"

# No contraction to fused multiply-add and no -ffast-math: every platform must give the same bits. What clang packs
# into vectors within straight-line code it first has to gather: the core is a tenth faster without. Nobody reads errno,
# so a root need not be a call. The functions of a shared library have no prefix (FMI 2.0.4, section 2.1.1).
FLAGS = (
    *("-shared", "-std=c99", "-O2", "-ffp-contract=off", "-fno-slp-vectorize", "-fno-math-errno", "-fPIC", "-g0", "-s"),
    *("-fvisibility=hidden", "-ffunction-sections", "-fdata-sections", "-Wall", "-Wextra", "-Wconversion", "-Werror"),
    "-DFMI2_OVERRIDE_FUNCTION_PREFIX",
)


@dataclass(frozen=True)
class Target:
    """A platform: where FMI looks for its library, and how zig makes it.

    Attributes
    ----------
    folder : str
        Folder below binaries/ in the FMU (FMI 2.0.4, section 2.3; those for Arm are the platform tuples of FMI 3.0).
    triples : tuple of str
        Target triples of zig; more than one are joined into a universal library.
    extension : str
        Of the library's file name, with its dot.
    flags : tuple of str
        Beside `FLAGS`; "{model}" stands for the name of the model.
    """

    folder: str
    triples: tuple[str, ...]
    extension: str
    flags: tuple[str, ...]


_ELF = ("-Wl,--gc-sections",)
# Without an install name the path of the build folder would go into the library.
_MACH = ("-Wl,-dead_strip", "-install_name", "@rpath/{model}.dylib")

TARGETS: tuple[Target, ...] = (
    Target("linux64", ("x86_64-linux-gnu.2.17",), ".so", _ELF),
    Target("aarch64-linux", ("aarch64-linux-gnu.2.17",), ".so", _ELF),
    Target("win64", ("x86_64-windows-gnu",), ".dll", _ELF),
    Target("darwin64", ("x86_64-macos.11.0", "aarch64-macos.11.0"), ".dylib", _MACH),
    Target("aarch64-darwin", ("aarch64-macos.11.0",), ".dylib", _MACH),
)

_HOSTS = {
    ("Linux", "x86_64"): "linux64",
    ("Linux", "aarch64"): "aarch64-linux",
    ("Windows", "AMD64"): "win64",
    ("Darwin", "x86_64"): "darwin64",
    ("Darwin", "arm64"): "darwin64",
}


def host_target() -> Target:
    """Return the target of the machine this runs on; BuildError if there is none."""
    machine = platform.system(), platform.machine()
    if machine not in _HOSTS:
        known = ", ".join(sorted({" ".join(host) for host in _HOSTS}))
        raise BuildError(f"no native FMU can be built on {' '.join(machine)}; expected one of {known}")
    return next(target for target in TARGETS if target.folder == _HOSTS[machine])


def recipe() -> str:
    """Return all that decides what becomes of the sources, as a text."""
    return f"zig {metadata.version('ziglang')}\n{FLAGS}\n{TARGETS}\n"


def compile_library(name: str, sources: dict[str, bytes], target: Target) -> bytes:
    """Return a shared library for one target, the same bytes wherever it is built.

    Parameters
    ----------
    name : str
        Of the library, and of the C file that is compiled: an FMU's model, for one.
    sources : dict of str to bytes
        All C files and headers by name; the FMI headers are added.

    Raises
    ------
    BuildError
        With the compiler's messages.
    """
    with tempfile.TemporaryDirectory(prefix="drillstring-") as folder:
        stage = Path(folder)
        for header in sorted(FMI_HEADERS.glob("fmi2*.h")):
            shutil.copy(header, stage)
        for file, content in sources.items():
            (stage / file).write_bytes(content)
        parts = [_compile(name, stage, target, triple) for triple in target.triples]
    return parts[0] if len(parts) == 1 else _universal(parts)


def _compile(name: str, stage: Path, target: Target, triple: str) -> bytes:
    # Every path is relative to the stage, so that neither zig's cache nor the library depends on where it lies.
    library = f"{name}{target.extension}"
    flags = [flag.format(model=name) for flag in (*FLAGS, *target.flags)]
    source = f"{name}.c"
    command = [sys.executable, "-m", "ziglang", "cc", "-target", triple, *flags, "-I.", source, "-o", library, "-lm"]
    run = subprocess.run(
        command, cwd=stage, env=compiler_environment(), capture_output=True, text=True, errors="replace", check=False
    )
    if run.returncode != 0 or not (stage / library).is_file():
        messages = (run.stderr or run.stdout).strip() or f"zig ended with exit code {run.returncode} and no message"
        raise BuildError(f"{name}: the C code does not compile for {triple}:\n{messages}")
    return (stage / library).read_bytes()


def compiler_environment() -> dict[str, str]:
    """Return the environment in which zig runs: its caches are kept in the checkout, where there is one."""
    environment = dict(os.environ)
    if (project.ROOT / "pyproject.toml").is_file():  # an installed package leaves the caches where zig puts them
        cache = project.ROOT / "build" / "zig"
        environment.setdefault("ZIG_LOCAL_CACHE_DIR", str(cache / "local"))
        environment.setdefault("ZIG_GLOBAL_CACHE_DIR", str(cache / "global"))
    return environment


def _universal(parts: list[bytes]) -> bytes:
    """Join Mach-O libraries of several processors into one (big-endian fat header, slices aligned to 2**14)."""
    align = 14
    offset = 1 << align
    header = struct.pack(">II", 0xCAFEBABE, len(parts))
    slices: list[tuple[int, bytes]] = []
    for part in parts:
        processor, subtype = struct.unpack_from("<II", part, 4)
        header += struct.pack(">IIIII", processor, subtype, offset, len(part), align)
        slices.append((offset, part))
        offset += -(-len(part) >> align) << align
    out = bytearray(header)
    for start, part in slices:
        out += bytes(start - len(out)) + part
    return bytes(out)
