"""What is to be said of a run when it is over: how well the coupling was computed, and what is not known of it."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from cosim.errors import format_time


def statement(record: Mapping[str, Any]) -> tuple[str, ...]:
    """Say it in sentences, from the record of a run; nothing for a run without connections."""
    if not record["connections"]:
        return ()
    sentences = [
        *(f"algebraic loop {loop}: {_closed(record)}{_guarded(loop, record)}" for loop in record["loops"]),
        *_iterations(record),
        *_error(record),
        *(_energy(name, account) for name, account in record["energy_residual"].items()),
        *(_guard(name, span) for name, span in record["guards"].items()),
    ]
    return tuple(sentences)


def _closed(record: Mapping[str, Any]) -> str:
    """Say what has become of the loops."""
    if "iterations" not in record:
        return f"{record['algorithm']} passes on values of the step before"
    unsolved = record["unsolved"]
    accuracy = f"to {record['iteration_tolerance']:g} of the values"
    if not unsolved["steps"]:
        return f"closed in every step, {accuracy}"
    return (
        f"not closed in {unsolved['steps']} of {record['steps']} steps, first at t = "
        f"{format_time(unsolved['first'])} s, by {unsolved['largest_residual']:.3g} at most; in the others {accuracy}"
    )


def _guarded(loop: str, record: Mapping[str, Any]) -> str:
    """Say which guards and limits stood in for a solution of a loop."""
    components = {name.partition(".")[0] for name in loop.split(" -> ")}
    names = [name for name in record["guards"] if name.partition(".")[0] in components]
    if "iterations" not in record or not names:
        return ""
    return f"; where {' or '.join(names)} is on, by the value of that guard or limit and not by a solution"


def _iterations(record: Mapping[str, Any]) -> list[str]:
    """Say how often steps were repeated."""
    if "iterations" not in record:
        return []
    found = record["iterations"]
    return [f"components of a loop were stepped {found['mean']:.2f} times a step, at most {found['most']} times"]


def _error(record: Mapping[str, Any]) -> list[str]:
    """Say what is known of the error, and how many steps it cost."""
    if "error_estimate" not in record:
        rejected = [_count(record["rejected"], "step") + " taken back"] if "rejected" in record else []
        return [*rejected, "error of the coupling not estimated (a tolerance asks for it)"]
    found = record["error_estimate"]
    text = (
        f"estimated error {found['largest']:.2g} in a step at most, {found['mean']:.2g} on average, relative to values "
        f"and nominal values; tolerance {record['tolerance']:g}, {_count(record['rejected'], 'step')} taken back"
    )
    if found["beyond_tolerance"]:
        text += f"; {found['beyond_tolerance']} of {record['steps']} steps beyond the tolerance at the smallest size"
    return [text]


def _energy(name: str, account: Mapping[str, Any]) -> str:
    """Say how much energy the coupling made or lost."""
    made = account["sum"]
    what = "made" if made > 0.0 else "lost"
    return f"energy {what} by the coupling at {name}: {abs(made):.3g} J of {account['exchanged']:.3g} J exchanged"


def _guard(name: str, span: Mapping[str, Any]) -> str:
    """Say where values are a guard's or a limit's."""
    return (
        f"{name} is on at {_count(span['points'], 'communication point')} from t = {format_time(span['first'])} s to "
        f"{format_time(span['last'])} s: values there are its own, not solutions"
    )


def _count(number: int, what: str) -> str:
    """Write how many there are of something."""
    return f"{number} {what}" if number == 1 else f"{number} {what}s"
