"""Run the cells of the tutorials so that what they print depends on nothing but them."""

from __future__ import annotations

import os
import shutil
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Generator

FOLDER = "ipython"
_STARTUP = Path(__file__).with_name("startup.py")


@contextmanager
def steady_kernel(folder: Path) -> Generator[None]:
    """Let IPython kernels begin with `startup.py`, and with nothing of the user's, while the context lasts.

    Parameters
    ----------
    folder : Path
        Where IPython keeps what it keeps.
    """
    startup = folder / "profile_default" / "startup" / _STARTUP.name
    startup.parent.mkdir(parents=True, exist_ok=True)
    shutil.copyfile(_STARTUP, startup)
    before = os.environ.get("IPYTHONDIR")
    os.environ["IPYTHONDIR"] = str(folder)
    try:
        yield
    finally:
        del os.environ["IPYTHONDIR"]
        if before is not None:
            os.environ["IPYTHONDIR"] = before
