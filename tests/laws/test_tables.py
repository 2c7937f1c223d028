"""Tables of a drilling program: what is read, and the sentence with which everything else is refused."""

from __future__ import annotations

from pathlib import Path

import pytest

from models.controllers.program import read_table
from tests.plant.drive import Drive
from tests.plant.fmi import DISCARD, OK, Instance

NUMBERS = "expected three numbers"
LIMITS = "expected |time| <= 1e9 s, |speed| <= 1e4 rad/s, 0 <= WOB <= 1e8 N"
ORDER = "expected times that do not fall, at most two rows at one time"
HEADER = "expected the header time,speed,WOB"
BAD = {
    # content, and what is said of it after the name of the file
    "no bytes": ("", None),
    "header only": ("time,speed,WOB\n", " has no rows; expected at least one"),
    "blank lines only": ("time,speed,WOB\n\n  \n", " has no rows; expected at least one"),
    "no header": ("0,1,2\n", f", line 1: {HEADER}"),
    "header of other columns": ("time,Omega,WOB\n0,1,2\n", f", line 1: {HEADER}"),
    "columns in another order": ("time,WOB,speed\n0,1,2\n", f", line 1: {HEADER}"),
    "semicolons": ("time,speed,WOB\n0;1;2\n", f", line 2: {NUMBERS}"),
    "two columns": ("time,speed,WOB\n0,1\n", f", line 2: {NUMBERS}"),
    "four columns": ("time,speed,WOB\n0,1,2,3\n", f", line 2: {NUMBERS}"),
    "an empty field": ("time,speed,WOB\n0,,2\n", f", line 2: {NUMBERS}"),
    "a word": ("time,speed,WOB\n0,1,2\n1,fast,2\n", f", line 3: {NUMBERS}"),
    "nan": ("time,speed,WOB\n0,nan,2\n", f", line 2: {NUMBERS}"),
    "infinity": ("time,speed,WOB\n0,inf,2\n", f", line 2: {NUMBERS}"),
    "hexadecimal": ("time,speed,WOB\n0,0x10,2\n", f", line 2: {NUMBERS}"),
    "underscores": ("time,speed,WOB\n0,1_0,2\n", f", line 2: {NUMBERS}"),
    "two signs": ("time,speed,WOB\n0,--1,2\n", f", line 2: {NUMBERS}"),
    "two points": ("time,speed,WOB\n0,1.2.3,2\n", f", line 2: {NUMBERS}"),
    "an exponent without digits": ("time,speed,WOB\n0,1e,2\n", f", line 2: {NUMBERS}"),
    "a point alone": ("time,speed,WOB\n0,.,2\n", f", line 2: {NUMBERS}"),
    "a number in two parts": ("time,speed,WOB\n0,1 0,2\n", f", line 2: {NUMBERS}"),
    "a number without end": ("time,speed,WOB\n0,1" + "0" * 300 + ",2\n", None),
    "infinity by its exponent": ("time,speed,WOB\n0,1e999,2\n", f", line 2: {LIMITS}"),
    "speed beyond its limit": ("time,speed,WOB\n0,10001,2\n", f", line 2: {LIMITS}"),
    "time beyond its limit": ("time,speed,WOB\n-2e9,1,2\n", f", line 2: {LIMITS}"),
    "negative weight": ("time,speed,WOB\n0,1,-1e-9\n", f", line 2: {LIMITS}"),
    "falling time": ("time,speed,WOB\n0,1,2\n\n3,1,2\n2.5,1,2\n", f", line 5: {ORDER}"),
    "three rows at one time": ("time,speed,WOB\n0,1,2\n3,1,2\n3,2,2\n3,3,2\n", f", line 5: {ORDER}"),
    "letters beyond ASCII": ("time,speed,WOB\n0,1\u00b2,2\n", None),
}
GOOD = {
    "plain": "time,speed,WOB\n0,1,2\n4,5,6\n",
    "line ends of Windows": "time,speed,WOB\r\n0,1,2\r\n4,5,6\r\n",
    "no line end at the end": "time,speed,WOB\n0,1,2\n4,5,6",
    "blanks and blank lines": "time, speed, WOB\n\n 0 , 1,2 \n\n\t4,\t5,6\n\n",
    "other ways to write numbers": "time,speed,WOB\n+0.,1e0,.2E+1\n4000e-3,05,6.0\n",
}


def written(folder: Path, content: str) -> Path:
    file = folder / "table.csv"
    file.write_bytes(content.encode())
    return file


def refusal(file: Path) -> str:
    with pytest.raises(ValueError, match="table ") as refused:
        read_table(str(file))
    return str(refused.value)


@pytest.mark.parametrize("name", BAD)
def test_bad_table_is_refused_with_file_line_and_what_was_expected(name, tmp_path):
    content, said = BAD[name]
    file = written(tmp_path, content)
    assert refusal(file).startswith(f"table {file}")
    if said is not None:
        assert refusal(file) == f"table {file}{said}"


@pytest.mark.parametrize("name", BAD)
def test_native_program_refuses_bad_tables_with_the_same_sentence(name, tmp_path):
    file = written(tmp_path, BAD[name][0])
    with Instance("DrillingProgram", name="driller") as program:
        assert program.set(table=str(file)) == OK
        assert program.initialize() != OK
        assert program.messages[-1].text.startswith(f"driller at t = 0 s: table {file}")
        if BAD[name][1] is not None:
            assert program.messages[-1].text == f"driller at t = 0 s: {refusal(file)}"
        assert program.set(table="") == OK
        assert program.call("ExitInitializationMode") == OK


def test_python_program_refuses_the_first_step_with_the_same_sentence(tmp_path):
    # pythonfmu cannot refuse the initialisation itself
    file = written(tmp_path, BAD["a word"][0])
    with Instance("DrillingProgram", "python", logging=True) as program:
        program.set(table=str(file))
        program.initialize()
        assert program.step(0.0, 1.0) == DISCARD
        assert refusal(file) in program.messages[-1].text


@pytest.mark.parametrize("path", ["missing.csv", ".", "a/b/c.csv"])
def test_file_that_cannot_be_read_is_refused(path, tmp_path):
    file = tmp_path / path
    assert refusal(file) == f"table {file} cannot be read; expected a CSV file with the header time,speed,WOB"
    with Instance("DrillingProgram") as program:
        program.set(table=str(file))
        assert program.initialize() != OK
        assert program.messages[-1].text.endswith(refusal(file))


@pytest.mark.parametrize("name", GOOD)
def test_good_table_is_read_however_it_is_written(name, tmp_path):
    assert read_table(str(written(tmp_path, GOOD[name]))).rows == ((0.0, 1.0, 2.0), (4.0, 5.0, 6.0))


@pytest.mark.parametrize("name", GOOD)
@pytest.mark.parametrize("packaging", ["native", "python"])
def test_good_table_is_followed_however_it_is_written(name, packaging, tmp_path):
    with Drive("DrillingProgram", {"table": str(written(tmp_path, GOOD[name]))}, packaging) as program:
        program.go(1.0)
        assert (program.get("Omega"), program.get("WOB")) == (2.0, 3.0)


@pytest.mark.parametrize("packaging", ["native", "python"])
def test_long_table_is_read_to_its_end(packaging, tmp_path):
    lines = ["time,speed,WOB", *(f"{0.25 * k},{k % 7},{1000 + k}" for k in range(20000))]
    with Drive("DrillingProgram", {"table": str(written(tmp_path, "\n".join(lines)))}, packaging) as program:
        program.go(0.25 * 19998.5)
        assert program.get("WOB") == 20998.5


@pytest.mark.parametrize("packaging", ["native", "python"])
def test_table_may_lie_in_a_folder_of_any_name(packaging, tmp_path):
    folder = tmp_path / "Bohrprogramm für Ölfeld 7 (100 %)"
    folder.mkdir()
    with Drive("DrillingProgram", {"table": str(written(folder, GOOD["plain"]))}, packaging) as program:
        assert program.get("Omega") == 1.0
