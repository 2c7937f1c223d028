"""What a model description leaves to the declared type of a variable."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest

from cosim.fmi2.model_description import read_description

TYPES = (
    '<SimpleType name="Rise"><Real quantity="Temperature" unit="degC" relativeQuantity="true"/></SimpleType>'
    "</TypeDefinitions>"
)
UNIT = '<Unit name="degC"><BaseUnit K="1" offset="273.15"/></Unit></UnitDefinitions>'


@pytest.mark.parametrize(
    ("real", "offset"),
    [
        ('<Real start="0" unit="degC" relativeQuantity="true"/>', 0.0),
        ('<Real start="0" declaredType="Rise"/>', 0.0),
        ('<Real start="0" declaredType="Rise" relativeQuantity="false"/>', 273.15),
        ('<Real start="0" unit="degC"/>', 273.15),
    ],
)
def test_a_difference_is_read_from_a_variable_or_its_type(
    make_probe: Callable[..., Path], real: str, offset: float
) -> None:
    replace = {"</TypeDefinitions>": TYPES, "</UnitDefinitions>": UNIT, '<Real start="0" unit="rpm"/>': real}
    variable = read_description(make_probe(replace=replace)).by_name["v"]
    assert variable.measured_in is not None
    assert (variable.measured_in.name, variable.measured_in.offset) == ("degC", offset)
