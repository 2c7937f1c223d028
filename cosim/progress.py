"""Show how far a long computation is, where somebody waits for it: in notebooks and at prompts of IPython, or if asked.

There a bar comes by itself after a while. A script prints nothing that it was not told to. In a notebook the bar is an
output of the cell, which needs no widgets and stays with what it said last; in a terminal it goes to standard error.
"""

from __future__ import annotations

import html
import sys
import time
from collections.abc import Callable, Generator
from contextlib import contextmanager
from typing import Any, Protocol, TypeVar

from cosim.errors import printable

Progress = Callable[[str, float], None]
"""Takes how far it is, in words, and which part of all is done, from 0 to 1."""

PATIENCE = 2.0
"""Seconds after which a bar comes by itself."""
_BETWEEN = 0.1
"""Seconds between two looks of a bar."""
_Callable = TypeVar("_Callable", bound=Callable[..., None])


@contextmanager
def shown(progress: Progress | bool | None, title: str) -> Generator[Progress | None]:
    """Show how far something is while the block runs.

    Parameters
    ----------
    progress : callable or bool, optional
        What is called instead; True: a bar at once, False: none. By default a bar where IPython runs, after a while.
    title : str
        What is being done.

    Yields
    ------
    callable or None
        To be called now and then; None where nothing is shown.
    """
    if callable(progress):
        yield progress
        return
    wanted = progress is True
    if not wanted and (progress is False or _shell() is None):
        yield None
        return
    bar = _Bar(title, 0.0 if wanted else PATIENCE)
    try:
        yield bar.tell
    except BaseException:
        bar.end("stopped")
        raise
    bar.end("done")


@contextmanager
def part_shown(
    progress: Callable[[float], None] | bool | None, title: str
) -> Generator[Callable[[float], None] | None]:
    """Show which part of something is done; as `shown`, for what takes the part alone."""
    if callable(progress):
        yield progress
        return
    with shown(progress, title) as told:
        yield None if told is None else lambda part: told("", part)


def _shell() -> Any:
    """Return the IPython that runs this; None if none does."""
    module: Any = sys.modules.get("IPython")
    return None if module is None else module.get_ipython()


class _Screen(Protocol):
    """Something that a bar is drawn on."""

    def draw(self, text: str, part: float) -> None:
        """Draw it, or draw it anew."""

    def end(self, text: str, part: float) -> None:
        """Draw it for the last time."""


class _Bar:
    """A bar that comes when there has been enough waiting."""

    def __init__(self, title: str, patience: float) -> None:
        self._title, self._began = title, time.monotonic()
        self._next = self._began + patience
        self._screen: _Screen | None = None
        self._part = 0.0
        if not patience:
            self._draw("", self._began)

    def tell(self, done: str, part: float) -> None:
        """Take how far it is."""
        self._part = min(1.0, max(0.0, part))
        now = time.monotonic()
        if now >= self._next:
            self._draw(done, now)

    def end(self, how: str) -> None:
        """Say how it ended, if a bar was seen."""
        if self._screen is not None:
            took = time.monotonic() - self._began
            part = 1.0 if how == "done" else self._part
            self._screen.end(f"{self._title}: {how} after {_duration(took)}", part)

    def _draw(self, done: str, now: float) -> None:
        """Draw what is known now."""
        if self._screen is None:
            self._screen = _Cell() if hasattr(_shell(), "kernel") else _Terminal()
        left = (now - self._began) * (1.0 - self._part) / self._part if self._part > 0.0 else None
        said = [self._title + (f": {done}" if done else ""), f"{100.0 * self._part:.0f} %"]
        self._screen.draw(", ".join(said + ([] if left is None else [f"{_duration(left)} left"])), self._part)
        self._next = now + _BETWEEN


def _duration(seconds: float) -> str:
    """Write seconds for people."""
    if seconds < 60.0:
        return f"{seconds:.0f} s" if seconds >= 10.0 else f"{seconds:.1f} s"
    minutes, rest = divmod(round(seconds), 60)
    return f"{minutes // 60}:{minutes % 60:02}:{rest:02}" if minutes >= 60 else f"{minutes}:{rest:02}"


class _Cell:
    """An output of a notebook's cell."""

    def __init__(self) -> None:
        self._handle: Any = None

    def draw(self, text: str, part: float) -> None:
        """Draw the bar, or draw it anew."""
        from IPython.display import display  # pyright: ignore[reportMissingImports, reportUnknownVariableType]

        said = printable(text)
        bundle = {
            "text/plain": said,
            "text/html": f'<progress max="1" value="{part:.4f}"></progress> {html.escape(said)}',
        }
        if self._handle is None:
            self._handle = display(bundle, raw=True, display_id=True)
        else:
            self._handle.update(bundle, raw=True)

    def end(self, text: str, part: float) -> None:
        """Draw it for the last time."""
        self.draw(text, part)


class _Terminal:
    """The terminal, on standard error."""

    def __init__(self) -> None:
        from rich.console import Console
        from rich.progress import BarColumn, Progress, TextColumn

        console = Console(stderr=True, highlight=False)
        columns = (BarColumn(), TextColumn("{task.description}", markup=False))
        self._bars = Progress(*columns, console=console, transient=console.is_terminal)
        self._task = self._bars.add_task("", total=1.0)
        self._bars.start()

    def draw(self, text: str, part: float) -> None:
        """Draw the bar anew."""
        self._bars.update(self._task, description=printable(text), completed=part)

    def end(self, text: str, part: float) -> None:
        """Leave the terminal as it was; a file has the last of it."""
        self.draw(text, part)
        self._bars.stop()
