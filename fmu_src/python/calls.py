"""Let code survive being called by the library that pythonfmu puts into an FMU.

That library answers any exception with fmi2Fatal and leaves its instance half destroyed: a later call, even
fmi2FreeInstance, can crash the process. It knows one other bad answer, "do_step returned False", which becomes
fmi2Discard.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import wraps
from math import nan
from typing import Any, Concatenate, ParamSpec, Protocol, TypeVar


class Guarded(Protocol):
    """Ask of an object what a guarded method needs of it."""

    def failed(self, call: str, error: BaseException) -> None:
        """Take note that a call has failed."""
        ...


P = ParamSpec("P")
R = TypeVar("R")
S = TypeVar("S", bound=Guarded)
Method = Callable[Concatenate[S, P], R]


def guarded(answer: Callable[..., R]) -> Callable[[Method[S, P, R]], Method[S, P, R]]:
    """Let no exception out of a method that the library calls; return `answer(*arguments)` instead.

    KeyboardInterrupt is caught as well: it reaches whatever Python code happens to run, and from here it would
    crash the process. The run still ends, because the next step is refused.
    """

    def decorate(method: Method[S, P, R]) -> Method[S, P, R]:
        @wraps(method)
        def call(self: S, *args: P.args, **kwargs: P.kwargs) -> R:
            try:
                return method(self, *args, **kwargs)
            except BaseException as error:
                self.failed(method.__name__, error)
                return answer(*args, **kwargs)

        return call

    return decorate


def nothing(*_: object) -> None:
    """Answer a call that has no answer."""


def refused(*_: object) -> bool:
    """Answer a step that is not taken."""
    return False


def saved_nothing(*_: object) -> dict[str, Any]:
    """Answer a call for a state with one that is of no model, so that restoring it is refused."""
    return {}


def _repeat(value: Any) -> Callable[[Sequence[int]], list[Any]]:
    return lambda references: [value] * len(references)


blank_reals = _repeat(nan)
blank_integers = _repeat(0)
blank_booleans = _repeat(False)
blank_strings = _repeat("")
