"""Log messages on the terminal, as sentences like those of errors."""

from __future__ import annotations

import logging

from rich.console import Console
from rich.text import Text

_FMU = "cosim.fmi2."


class SentenceHandler(logging.Handler):
    """Shows warnings as they come, but holds back what an FMU says about a failed call.

    If the failure ends the run, its error says the same; if not, `show_failures` makes up for it.

    Parameters
    ----------
    console : rich.console.Console
        Where to write.
    """

    def __init__(self, console: Console) -> None:
        super().__init__(logging.WARNING)
        self._console = console
        self._failures: list[logging.LogRecord] = []
        self._shown: set[str] = set()

    def emit(self, record: logging.LogRecord) -> None:
        """Show a message, or hold it back."""
        if getattr(record, "says_why", False):
            self._failures.append(record)
        else:
            self._show(record)

    def show_failures(self) -> None:
        """Show what was held back."""
        for record in self._failures:
            self._show(record)

    def _show(self, record: logging.LogRecord) -> None:
        """Write one sentence; what an FMU says again when a step is repeated is written once."""
        instance = f"{record.name.removeprefix(_FMU)}: " if record.name.startswith(_FMU) else ""
        level = "warning" if record.levelno < logging.ERROR else "error"
        sentence = f"{instance}{plain(record.getMessage())}"
        if not instance or sentence not in self._shown:
            self._console.print(Text.assemble((f"{level}: ", "bold yellow"), sentence))
        self._shown.add(sentence)


def plain(text: str) -> str:
    """Return a text with characters that a terminal would act upon, such as escape sequences, written out."""
    return "".join(each if each.isprintable() else each.encode("unicode_escape").decode() for each in text)
