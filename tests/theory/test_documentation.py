"""Everything the theory exports is documented in full: parameters with units, results, errors, source."""

from __future__ import annotations

import inspect
import re

import pytest

from models import cycle, parameters, spectrum, theory

EXPORTED = {
    f"{module.__name__}.{name}": getattr(module, name)
    for module in (theory, parameters, spectrum, cycle)
    for name in module.__all__
}
FUNCTIONS = sorted(name for name, exported in EXPORTED.items() if inspect.isfunction(exported))
CLASSES = sorted(name for name, exported in EXPORTED.items() if inspect.isclass(exported))


@pytest.mark.parametrize("name", FUNCTIONS)
def test_function_tells_its_parameters_and_result(name: str) -> None:
    function = EXPORTED[name]
    text = inspect.getdoc(function) or ""
    assert re.match(r"(Return|Measure|Follow|Tell) ", text)
    described = text.partition("Parameters\n---")[2].partition("Returns\n---")
    assert all(described), "expected the sections Parameters and Returns"
    for parameter in inspect.signature(function).parameters:
        assert re.search(rf"^(\w+, )*{parameter}(, \w+)* : ", described[0], re.MULTILINE), parameter
    if "raise " in inspect.getsource(function):
        assert "Raises\n---" in text


@pytest.mark.parametrize("name", CLASSES)
def test_class_tells_its_fields(name: str) -> None:
    text = inspect.getdoc(EXPORTED[name]) or ""
    for field in EXPORTED[name].__annotations__:
        if not field.isupper() or len(field) <= 1:
            assert re.search(rf"^(\w+, )*{field}(, \w+)* : ", text, re.MULTILINE), field
