"""The friction law is written once a language: its torque, its slope and its inverse agree with each other."""

from __future__ import annotations

import ast
import math
import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from models.plant.friction import Friction, FrictionParameters, greatest_fall, torque_on_bit
from models.plant.slip import BitLaw
from models.theory.stability.torque_curve import TorqueCurve
from tests.theory.strings import PAPER

ROOT = Path(__file__).parents[2]
OWN_WORDS = re.compile(r"\b(mu_cb|mu_sb|gamma_b|v_f|coulomb|excess)\b")
"""Names of what eq. (4) is made of; another law has others."""

LEVERS = [1.0, 0.155575, 97347.0 * 0.155575]


def test_slope_is_the_derivative_of_the_torque() -> None:
    falling = replace(PAPER, mu_cb=0.0)  # a constant part would only add its rounding to the difference
    for lever in LEVERS:
        friction = Friction.of(falling, lever)
        for speed in (0.1, 1.0, 7.5):
            difference = friction.at(3.0, speed + 1e-5)[1] - friction.at(3.0, speed - 1e-5)[1]
            assert friction.at(3.0, speed)[2] == pytest.approx(difference / 2e-5, rel=1e-8)


def test_inverse_finds_the_speed_of_a_slope_and_none_where_there_is_none() -> None:
    friction = Friction.of(PAPER, 1000.0)
    for speed in (0.01, 1.0, 7.5):
        slope = friction.at(1.0, speed)[2]
        assert friction.speed_of_slope(slope, math.log) == pytest.approx(speed, rel=1e-12)
    steepest = friction.at(1.0, 0.0)[2]
    assert friction.speed_of_slope(steepest * 1.01, math.log) is None
    assert friction.speed_of_slope(0.0, math.log) is None
    assert greatest_fall(PAPER) == pytest.approx(-steepest / 1000.0 * PAPER.R_b, rel=1e-14)


def test_a_friction_that_does_not_fall_has_no_greatest_fall() -> None:
    with pytest.raises(ValueError, match="expected mu_sb > mu_cb and gamma_b > 0"):
        greatest_fall(FrictionParameters(gamma_b=0.0))


def test_program_bit_and_theory_ask_the_same_law() -> None:
    weight = 97347.0
    curve, bit = TorqueCurve.of(PAPER, weight), BitLaw.of(PAPER).friction
    for speed in (0.3, 2.0, 11.0):
        torque = torque_on_bit(PAPER, weight, speed)
        assert PAPER.c_b * speed + bit.at(weight, speed)[1] == pytest.approx(torque, rel=1e-15)
        assert curve.torque(np.array([speed]))[0] == pytest.approx(torque, rel=1e-14)
        assert torque_on_bit(PAPER, weight, -speed) == -torque


def words_of_python(path: Path) -> set[str]:
    """Return the words of the law that the code of a file speaks, apart from its docstrings."""
    tree = ast.parse(path.read_text(encoding="utf-8"))
    texts = {id(node.value) for node in ast.walk(tree) if isinstance(node, ast.Expr)}
    words: set[str] = set()
    for node in ast.walk(tree):
        match node:
            case ast.Name(id=word) | ast.Attribute(attr=word) | ast.keyword(arg=str(word)):
                words |= set(OWN_WORDS.findall(word))
            case ast.Constant(value=str(text)) if id(node) not in texts:
                words |= set(OWN_WORDS.findall(text))
            case _:
                pass
    return words


def test_another_friction_law_touches_two_files_of_python() -> None:
    # documentation pages print the equation, as they print all others
    files = (path for folder in ("models", "cosim", "fmu_src") for path in (ROOT / folder).rglob("*.py"))
    paths = [path for path in files if path.name != "page.py"]
    assert {path.name for path in paths if len(words_of_python(path)) > 1} == {"friction.py", "rows.py"}


def test_another_friction_law_touches_two_files_of_c() -> None:
    comments = re.compile(r"/\*.*?\*/", re.DOTALL)
    paths = (ROOT / "fmu_src").rglob("*.[ch]")
    speaking = {path.name for path in paths if OWN_WORDS.search(comments.sub("", path.read_text(encoding="utf-8")))}
    assert speaking == {"ds_friction.h", "ds_friction_table.h"}
