"""Compare what a block prints with what its page shows.

The comparison is of every character, but for blanks at the ends of lines, and

- `...` in the page, which stands for any text within a line, and alone in a line for any lines;
- a time of computing, `in 0.0107 s`, which stands for any other;
- a line that begins with four blanks, which may go on the line before: long lines are broken so for the page.
"""

from __future__ import annotations

import difflib
import re

_NUMBER = r"[-+]?(?:\d+\.?\d*(?:e[-+]?\d+)?|inf|nan)"
_TIME = re.compile(r"(?<![\w.])in " + _NUMBER + r" s(?!\w)")
_FIGURE = re.compile(r"(?<![\w.])" + _NUMBER + r"(?![\w])")
_MARKS = re.compile(rf"(?P<dots>\.\.\.)|(?P<time>{_TIME.pattern})|(?P<broken>\n {{4}})")
_MARKS_AND_FIGURES = re.compile(rf"{_MARKS.pattern}|(?P<figure>{_FIGURE.pattern})|(?P<blanks> +)")
_STANDS_FOR = {
    "dots": r"[^\n]*?",
    "time": rf"in {_NUMBER} s",
    "broken": r"(?:\n {4}| )",
    "figure": _NUMBER,
    "blanks": " +",
}


def differences(shown: str, printed: str, figures: bool = True) -> str:
    """Return how an output differs from what is shown of it; nothing where it does not.

    Parameters
    ----------
    shown, printed
        Text of the page, and of the run.
    figures
        Whether numbers are compared; else a number stands for any other, and blanks for any number of them.
    """
    shown, printed = _trimmed(shown), _trimmed(printed)
    if re.fullmatch(pattern(shown, figures), printed):
        return ""
    return "\n".join(difflib.unified_diff(shown.splitlines(), printed.splitlines(), "shown", "printed", lineterm=""))


def pattern(shown: str, figures: bool = True) -> str:
    """Return the regular expression that a page's text stands for."""
    parts: list[str] = []
    # lines of dots first: what is between them is one piece, in which lines may be broken
    for index, piece in enumerate(re.split(r"(?m)^\.\.\.\n", shown)):
        parts += [r"(?:[^\n]*\n)*?"] if index else []
        parts.append(_of_piece(piece, _MARKS if figures else _MARKS_AND_FIGURES))
    return "".join(parts)


def _of_piece(text: str, marks: re.Pattern[str]) -> str:
    parts: list[str] = []
    end = 0
    for found in marks.finditer(text):
        parts += [re.escape(text[end : found.start()]), _STANDS_FOR[found.lastgroup or ""]]
        end = found.end()
    return "".join([*parts, re.escape(text[end:])])


def _trimmed(text: str) -> str:
    lines = [line.rstrip() for line in text.strip("\n").splitlines()]
    return "".join(f"{line}\n" for line in lines)
