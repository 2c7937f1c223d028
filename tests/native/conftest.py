"""What not every machine has is asked for: a test that needs it is skipped, and in continuous integration it fails."""

from __future__ import annotations

import os
from collections.abc import Iterator

import pytest

from tests.native.programs import MissingToolError


@pytest.hookimpl(wrapper=True)
def pytest_pyfunc_call() -> Iterator[None]:
    try:
        return (yield)
    except MissingToolError as error:
        if "CI" in os.environ:
            raise
        pytest.skip(str(error))
