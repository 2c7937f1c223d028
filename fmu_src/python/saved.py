"""A saved state as bytes: JSON behind a checksum."""

from __future__ import annotations

import json
from hashlib import sha256
from typing import Any, cast

from . import calls

_DIGEST_SIZE = 64


def encoded(state: dict[str, Any]) -> bytes:
    """Return a state as bytes."""
    # json writes floats by repr, the shortest text that reads back as the same bits
    content = json.dumps(state, separators=(",", ":")).encode()
    return _digest(content) + content


def decoded(content: bytes) -> dict[str, Any]:
    """Return the state that bytes hold; one that nothing can be restored from if they are damaged."""
    digest, text = content[:_DIGEST_SIZE], content[_DIGEST_SIZE:]
    if digest != _digest(text):  # a digit that is flipped would be a number as well
        return calls.saved_nothing()
    try:
        return cast("dict[str, Any]", json.loads(text))
    except (ValueError, RecursionError):
        return calls.saved_nothing()


def _digest(content: bytes) -> bytes:
    return sha256(content).hexdigest().encode()
