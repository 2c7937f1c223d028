"""A law from a file of the user's: what it can be, and a sentence with the line for what is wrong in it."""

from __future__ import annotations

from pathlib import Path

import pytest
from typer.testing import CliRunner

from fmu_src.build.command import app
from fmu_src.errors import BuildError
from fmu_src.fmus.own import read_law

LAW = '''\
"""A gain."""

from fmu_src.python.law import MemorylessLaw
from fmu_src.rows import input_row, output_row, parameter_row
from fmu_src.schema import Model

MODEL = Model(
    name="Gain",
    description="A weight that follows the bit",
    variables=(
        input_row("bit_speed", "rad/s", 0.0, "Speed of the bit", ""),
        output_row("WOB", "N", "Weight", "", needs=("bit_speed",), initially=("bit_speed", "gain")),
        parameter_row("gain", "N.s/rad", 100.0, 0.0, 1e6, "Gain"),
    ),
)


class Gain(MemorylessLaw):
    model = MODEL

    def answer(self, values, time):
        values[self.at["WOB"]] = values[self.at["gain"]] * values[self.at["bit_speed"]]
'''

BRINGS = "an FMU brings no other package or file"
CANNOT = "cannot be imported; expected the standard library, fmu_src or models"


def law(folder: Path, old: str = "", new: str = "", name: str = "Gain") -> Path:
    """Write the law with something replaced."""
    assert old in LAW
    path = folder / f"{name}.py"
    path.write_text(LAW.replace(old, new, 1) if old else LAW, encoding="utf-8")
    return path


def test_a_law_of_any_kind_is_read_with_its_table(tmp_path: Path) -> None:
    read = read_law(law(tmp_path))
    assert (read.model.name, read.module) == ("Gain", "fmu_src.fmus.Gain.interface")
    assert [variable.name for variable in read.model.variables] == ["bit_speed", "WOB", "gain"]


@pytest.mark.parametrize(
    ("old", "new", "sentence"),
    [
        ("from fmu_src.schema", "import numpy\nfrom fmu_src.schema", f"line 5: {BRINGS}, so numpy {CANNOT}"),
        ("from fmu_src.schema", "from .gains import K\nfrom fmu_src.schema", f"line 5: {BRINGS}, so .gains {CANNOT}"),
        ("fmu_src.schema import", "fmu_src.scheme import", "line 5: ModuleNotFoundError: No module named"),
        ("MODEL = Model(", "MODEL = = Model(", "line 7: invalid syntax"),
        ('name="Gain"', 'name="Again"', "defines no MODEL with the name of the file, Gain"),
        ("class Gain(", "class Again(", "defines no class Gain of a law, with model = MODEL"),
        ("(MemorylessLaw)", "", "defines no class Gain of a law, with model = MODEL"),
        ("model = MODEL", "pass", "defines no class Gain of a law, with model = MODEL"),
        ('self.at["gain"]', 'self.at["gian"]', "line 22: KeyError: 'gian'"),
        ("def answer", "def answers", "TypeError: Can't instantiate abstract class Gain"),
    ],
)  # fmt: skip
def test_what_is_wrong_in_it_is_one_sentence(old: str, new: str, sentence: str, tmp_path: Path) -> None:
    path = law(tmp_path, old, new)
    with pytest.raises(BuildError) as caught:
        read_law(path)
    assert str(caught.value).startswith(str(path))
    assert sentence in str(caught.value)


@pytest.mark.parametrize(
    ("name", "sentence"),
    [
        ("SoftTorque", "SoftTorque is an FMU of this project; expected another name"),
        ("my-gain", "'my-gain' is no name of an FMU; expected letters, digits and _"),
    ],
)
def test_a_file_of_another_name_is_refused(name: str, sentence: str, tmp_path: Path) -> None:
    with pytest.raises(BuildError, match=sentence):
        read_law(law(tmp_path, name=name))


def test_a_file_that_is_not_there_is_a_sentence(tmp_path: Path) -> None:
    done = CliRunner().invoke(app, [str(tmp_path / "none.py")])
    assert done.exit_code == 1
    assert "none.py cannot be read" in done.stderr


def test_a_unit_that_nobody_defines_is_a_sentence_and_leaves_no_fmu(tmp_path: Path) -> None:
    done = CliRunner().invoke(app, [str(law(tmp_path, "N.s/rad", "lbf"))])
    assert done.exit_code == 1
    assert "Gain: no unit definition for lbf" in done.stderr
    assert [path.name for path in tmp_path.iterdir()] == ["Gain.py"]


def test_it_has_no_native_packaging(tmp_path: Path) -> None:
    done = CliRunner().invoke(app, [str(law(tmp_path)), "--packaging", "native"])
    assert done.exit_code == 2
    assert "has no C code; expected --packaging python" in " ".join(done.stderr.replace("│", " ").split())


@pytest.mark.slow
def test_it_goes_beside_its_file_or_where_it_is_told(tmp_path: Path) -> None:
    path = law(tmp_path)
    assert CliRunner().invoke(app, [str(path)]).exit_code == 0
    assert CliRunner().invoke(app, [str(path), "--output", str(tmp_path / "out")]).exit_code == 0
    assert (tmp_path / "Gain.fmu").read_bytes() == (tmp_path / "out" / "python" / "Gain.fmu").read_bytes()
