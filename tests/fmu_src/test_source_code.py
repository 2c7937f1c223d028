"""The folder sources/ of every native FMU of dist/: whoever compiles it gets the FMU, to the last bit."""

from __future__ import annotations

import os
import platform
import re
import shutil
import subprocess
import sys
import zipfile
from collections.abc import Callable
from pathlib import Path

import fmpy
import lief
import pytest
from lxml import etree

from fmu_src.build.native import FMI_HEADERS
from fmu_src.fmus import MODELS
from tests.fmu_src.conftest import Instance
from tests.once import built_once

pytestmark = pytest.mark.slow

NATIVE = Path(__file__).parents[2] / "dist" / "native"
SCHEMAS = Path(fmpy.__file__).parent / "schema" / "fmi3"
WARNINGS = ("-std=c99", "-Wall", "-Wextra", "-Wconversion", "-Wshadow", "-pedantic")
LINKED = ("DrillingProgram", "DrillstringNeutral", "DissipativeLaw", "WeightOnBitLaw")


@pytest.fixture(params=["gcc", "clang"])
def compiler(request: pytest.FixtureRequest) -> str:
    """A compiler other than ours; continuous integration has both."""
    if shutil.which(request.param) is None and "CI" not in os.environ:
        pytest.skip(f"there is no {request.param} on this machine")
    return request.param


def unpack(name: str, folder: Path) -> Path:
    """Unpack the sources of an FMU into a folder and return the path of the one to compile."""
    with zipfile.ZipFile(NATIVE / f"{name}.fmu") as archive:
        archive.extractall(folder, [member for member in archive.namelist() if member.startswith("sources/")])
    return folder / "sources" / f"{name}.c"


def compile_source(compiler: str, source: Path, *flags: object, headers: Path = FMI_HEADERS) -> str:
    """Run a compiler over one source, which must not draw a message, and return what it prints."""
    command = [compiler, *map(str, flags), f"-I{headers}", str(source)]
    run = subprocess.run(command, capture_output=True, text=True, check=False)
    assert (run.returncode, run.stderr) == (0, "")
    return run.stdout


def walk(fmu: Instance, path: Path) -> list[tuple[float, ...]]:
    """Run an FMU, with inputs that swing, and return its real outputs at every communication point."""
    variables = fmpy.read_model_description(str(path)).modelVariables
    outputs = [v.valueReference for v in variables if v.causality == "output" and v.type == "Real"]
    inputs = [(v.valueReference, float(v.start)) for v in variables if v.causality == "input" and v.type == "Real"]
    fmu.initialize()
    rows: list[tuple[float, ...]] = []
    for k in range(1200):
        fmu.setReal([number for number, _ in inputs], [start * (1.0 + (k % 7) / 64.0) for _, start in inputs])
        fmu.doStep(k * 0.01, 0.01)
        rows.append(tuple(fmu.getReal(outputs)))
    return rows


@pytest.mark.parametrize("name", MODELS)
def test_sources_compile_as_c99_without_a_warning(name: str, compiler: str, tmp_path: Path) -> None:
    source = unpack(name, tmp_path)
    compile_source(compiler, source, *WARNINGS, "-O2", "-fPIC", "-shared", "-o", tmp_path / "library.so")


@pytest.mark.parametrize("name", MODELS)
def test_sources_hold_all_but_the_fmi_headers_and_nothing_unused(name: str, tmp_path: Path) -> None:
    source = unpack(name, tmp_path)
    shipped = {path.name for path in source.parent.iterdir()} - {"buildDescription.xml"}
    listed = compile_source("gcc", source, "-M").replace("\\\n", " ").split()[1:]
    used = {Path(path).name for path in listed if Path(path).parent == source.parent}
    assert shipped == used


@pytest.mark.parametrize("name", MODELS)
def test_description_and_build_description_name_the_file_to_compile(name: str) -> None:
    with zipfile.ZipFile(NATIVE / f"{name}.fmu") as archive:
        listed = etree.fromstring(archive.read("modelDescription.xml")).findall("CoSimulation/SourceFiles/File")
        build = etree.fromstring(archive.read("sources/buildDescription.xml"))
    assert [file.get("name") for file in listed] == [f"{name}.c"]
    schema = etree.XMLSchema(file=str(SCHEMAS / "fmi3BuildDescription.xsd"))
    assert schema.validate(build), schema.error_log
    assert [file.get("name") for file in build.iter("SourceFile")] == [f"{name}.c"]


@pytest.mark.parametrize("name", MODELS)
def test_only_functions_of_fmi_are_visible_whatever_the_flags(name: str, compiler: str, tmp_path: Path) -> None:
    library = tmp_path / "library.so"
    compile_source(compiler, unpack(name, tmp_path), "-fPIC", "-shared", "-o", library)
    found = lief.ELF.parse(str(library))
    assert found is not None
    exported = {str(symbol.name) for symbol in found.exported_functions}
    assert {name for name in exported if not name.startswith("fmi2")} <= {"_init", "_fini"}


@pytest.mark.parametrize("level", ["-O2", "-O3"])
@pytest.mark.parametrize("name", MODELS)
def test_no_product_is_fused_with_a_sum(name: str, level: str, compiler: str, tmp_path: Path) -> None:
    flags = [level, "-S", "-o", "-", *(["-mfma", "-mavx2"] if platform.machine() in ("x86_64", "AMD64") else [])]
    source = unpack(name, tmp_path)
    fused = re.compile(r"\bv?fn?m(?:add|sub|la|ls)\w*")
    assert fused.findall(compile_source(compiler, source, *flags)) == []
    bare = source.with_name("bare.c")
    bare.write_text(source.read_text().replace('#include "ds_arithmetic.h"\n', ""))
    assert fused.findall(compile_source(compiler, bare, *flags)) != []


@pytest.mark.parametrize("compiler", ["gcc"], indirect=True)
def test_fast_math_is_refused_with_the_reason(compiler: str, tmp_path: Path) -> None:
    command = [compiler, "-ffast-math", f"-I{FMI_HEADERS}", "-fsyntax-only", str(unpack("WeightOnBitLaw", tmp_path))]
    run = subprocess.run(command, capture_output=True, text=True, check=False)
    assert run.returncode != 0
    assert "compile without -ffast-math" in run.stderr


@pytest.mark.parametrize("name", MODELS)
def test_the_command_on_the_page_compiles_the_library(name: str, compiler: str, tmp_path: Path) -> None:
    unpack(name, tmp_path)
    with zipfile.ZipFile(NATIVE / f"{name}.fmu") as archive:
        page = archive.read("documentation/index.html").decode()
    (command,) = re.findall(r"<pre><code>cc (.*)</code></pre>", page)
    arguments = command.replace("HEADERS", str(FMI_HEADERS)).split()
    run = subprocess.run([compiler, *arguments], cwd=tmp_path, capture_output=True, text=True, check=False)
    assert (run.returncode, run.stdout, run.stderr) == (0, "", "")
    assert (tmp_path / f"{name}.so").is_file()


@pytest.mark.parametrize("name", MODELS)
def test_fmpy_compiles_the_sources_to_an_fmu_of_the_same_bits(
    name: str, compiler: str, instantiate: Callable[..., Instance], tmp_path: Path
) -> None:
    ours, theirs = NATIVE / f"{name}.fmu", tmp_path / f"{name}.fmu"
    with zipfile.ZipFile(ours) as full, zipfile.ZipFile(theirs, "w") as bare:
        for member in full.namelist():
            if not member.startswith("binaries/"):  # cmake keeps a library it finds there if it is less than 1 s old
                bare.writestr(member, full.read(member))
    path = os.pathsep.join([str(Path(sys.executable).parent), os.environ["PATH"]])  # cmake is one of our packages
    environment = os.environ | {"PATH": path, "CC": compiler}
    flags = ("--all-warnings", "--warning-as-error")
    command = [sys.executable, "-m", "fmpy", "compile", *flags, str(theirs)]
    run = subprocess.run(command, env=environment, capture_output=True, text=True, check=False)
    assert run.returncode == 0, run.stdout + run.stderr
    assert "warning" not in run.stdout + run.stderr
    assert walk(instantiate(theirs), theirs) == walk(instantiate(ours), ours)


@pytest.fixture(scope="session")
def prefixing_headers(run_folder: Path) -> Path:
    """The FMI headers with the prefix for functions of source code FMUs, which fmpy leaves out of its copy."""
    return built_once(run_folder / "headers", copy_headers)


def copy_headers(folder: Path) -> None:
    for header in FMI_HEADERS.glob("fmi2*.h"):
        shutil.copy(header, folder)
    text = (folder / "fmi2Functions.h").read_text()
    plain = "#define fmi2FullName(name) name\n"
    paste = "#define fmi2Paste(a, b) a##b\n#define fmi2PasteB(a, b) fmi2Paste(a, b)\n"
    assert plain in text
    prefixed = paste + "#define fmi2FullName(name) fmi2PasteB(FMI2_FUNCTION_PREFIX, name)\n"
    (folder / "fmi2Functions.h").write_text(text.replace(plain, prefixed))


def linked_program(compiler: str, headers: Path, folder: Path) -> Path:
    """Link all FMUs and the program that couples them."""
    parts = [folder / f"{name}.o" for name in LINKED]
    references: list[str] = []
    for name, part in zip(LINKED, parts, strict=True):
        source = unpack(name, folder / name)
        compile_source(compiler, source, *WARNINGS, "-O2", "-c", "-o", part, headers=headers)
        description = fmpy.read_model_description(str(NATIVE / f"{name}.fmu"))
        references.append(f'#define GUID_{name} "{description.guid}"')
        references += [f"#define {name}_{v.name} {v.valueReference}" for v in description.modelVariables]
    (folder / "references.h").write_text("\n".join([*references, ""]))
    program = folder / "program"
    source = Path(__file__).with_name("linked.c")
    compile_source(compiler, source, *WARNINGS, f"-I{folder}", *parts, "-lm", "-o", program, headers=headers)
    return program


def test_fmus_linked_into_one_program_give_the_bits_of_the_libraries(
    compiler: str, prefixing_headers: Path, instantiate: Callable[..., Instance], tmp_path: Path
) -> None:
    program = linked_program(compiler, prefixing_headers, tmp_path)
    for name in LINKED:
        part = lief.ELF.parse(str(tmp_path / f"{name}.o"))
        assert part is not None
        names = [str(s.name) for s in part.symbols if s.binding == lief.ELF.Symbol.BINDING.GLOBAL and s.shndx != 0]
        assert f"{name}_fmi2DoStep" in names
        assert [found for found in names if not found.startswith(f"{name}_fmi2")] == []
    run = subprocess.run([program], capture_output=True, text=True, check=False)
    assert (run.returncode, run.stderr) == (0, "")
    assert [float(line) for line in run.stdout.split()] == coupled(instantiate)


def coupled(instantiate: Callable[..., Instance]) -> list[float]:
    """Run what linked.c runs, with the libraries of the FMUs, and return the bit speed at every communication point."""
    numbers = {
        name: {
            v.name: v.valueReference for v in fmpy.read_model_description(str(NATIVE / f"{name}.fmu")).modelVariables
        }
        for name in LINKED
    }
    fmus = {name: instantiate(NATIVE / f"{name}.fmu", name) for name in LINKED}
    fmus["DissipativeLaw"].setInteger([numbers["DissipativeLaw"]["form"]], [2])
    for fmu in fmus.values():
        fmu.initialize()
    wires = [
        (("DrillingProgram", "bit_speed_ref"), ("DissipativeLaw", "bit_speed_ref")),
        (("DrillingProgram", "bit_torque_ref"), ("DissipativeLaw", "bit_torque_ref")),
        (("DrillstringNeutral", "top_speed"), ("DissipativeLaw", "top_speed")),
        (("DrillstringNeutral", "bit_speed"), ("DissipativeLaw", "bit_speed")),
        (("DrillstringNeutral", "bit_speed"), ("WeightOnBitLaw", "bit_speed")),
        (("DissipativeLaw", "Omega"), ("DrillstringNeutral", "Omega")),
        (("WeightOnBitLaw", "WOB"), ("DrillstringNeutral", "WOB")),
    ]
    speeds: list[float] = []
    for k in range(8000):
        for (source, output), (sink, target) in wires:
            value = fmus[source].getReal([numbers[source][output]])
            fmus[sink].setReal([numbers[sink][target]], value)
        for fmu in fmus.values():
            fmu.doStep(k * 0.001, 0.001)
        speeds += fmus["DrillstringNeutral"].getReal([numbers["DrillstringNeutral"]["bit_speed"]])
    return speeds
