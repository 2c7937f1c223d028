"""No FMU of the python packaging holds the theory: it would need numpy and scipy, which an importer may not have."""

from __future__ import annotations

import re

import pytest

from fmu_src.build.python_packaging import bundle, slave_module
from fmu_src.fmus import MODELS


@pytest.mark.parametrize("model", sorted(MODELS))
def test_bundle_needs_no_numpy(model):
    _, files = bundle(slave_module(MODELS[model]))
    assert any(name.endswith("/fmu_src/python/slave.py") for name in files)
    words = {
        word for source in files.values() for word in re.findall(rb"^\s*(?:import|from) (\w+)", source, re.MULTILINE)
    }
    assert not words & {b"numpy", b"scipy"}
    assert b"math" in words
