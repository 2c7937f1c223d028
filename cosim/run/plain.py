"""Records as JSON can hold them."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any, cast


def plain(value: Any) -> Any:
    """Turn a value into what JSON knows; infinite numbers as ``"inf"``, since JSON has none."""
    if isinstance(value, Mapping):
        return {str(key): plain(inner) for key, inner in cast(Mapping[Any, Any], value).items()}
    if isinstance(value, list | tuple):
        return [plain(inner) for inner in cast(list[Any], value)]
    if isinstance(value, float) and not math.isfinite(value):
        return repr(value)
    return value
