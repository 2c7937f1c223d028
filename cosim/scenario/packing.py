"""Files to give away: zip archives that depend on nothing but names and contents, in place once they are complete."""

from __future__ import annotations

import io
import os
import tempfile
import zipfile
from collections.abc import Mapping
from pathlib import Path

from cosim.errors import OutputError

_EPOCH = (1980, 1, 1, 0, 0, 0)


def pack(files: Mapping[str, bytes], first: str) -> bytes:
    """Return a zip archive; stored, since compressors differ in the bytes they make.

    Parameters
    ----------
    files : mapping of str to bytes
        Contents by name.
    first : str
        The one to begin with, the description.
    """
    buffer = io.BytesIO()
    with zipfile.ZipFile(buffer, "w", zipfile.ZIP_STORED) as out:
        for name in sorted(files, key=lambda name: (name != first, name)):
            entry = zipfile.ZipInfo(name, _EPOCH)
            entry.create_system = 3  # Unix, on every host, so that the permissions below count
            entry.external_attr = 0o100644 << 16
            out.writestr(entry, files[name])
    return buffer.getvalue()


def put_in_place(path: Path, content: bytes) -> None:
    """Write a file, which appears when it is complete; folders above it are made.

    Raises
    ------
    OutputError
        If it cannot be written.
    """
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryDirectory(prefix=f".{path.name}-", dir=path.parent) as folder:
            draft = Path(folder, path.name)
            draft.write_bytes(content)
            os.replace(draft, path)
    except OSError as error:
        raise OutputError(f"{path} cannot be written: {error.strerror or error}") from error
