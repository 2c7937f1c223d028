"""The page of the reference for the command line, as Typer writes it from the commands themselves."""

from __future__ import annotations

import os
import re
import subprocess
import sys

_SHORTENED = re.compile(r"\*\*Commands\*\*:\n\n(\* .*\n)+\n")


def commands_page() -> str:
    """Return the page: every command, argument and option.

    Raises
    ------
    subprocess.CalledProcessError
        Typer cannot read the commands.
    """
    command = ["typer", "cosim.cli.app", "utils", "docs", "--name", "cosim", "--title", "Commands"]
    run = subprocess.run(
        [sys.executable, "-m", *command],
        check=True,
        capture_output=True,
        text=True,
        encoding="utf-8",
        env={**os.environ, "COLUMNS": "200"},
    )
    return _SHORTENED.sub("", run.stdout)  # that list is cut short; the page's own contents are not
