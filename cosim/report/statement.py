"""Say in sentences how well a run was coupled, and what is not known of it."""

from __future__ import annotations

from typing import TYPE_CHECKING

from cosim.errors import format_time

if TYPE_CHECKING:
    from cosim.run.report import CouplingReport, EnergyResidual, GuardSpan, NotEstimated, NotIterated


def statement(coupling: CouplingReport) -> tuple[str, ...]:
    """Say in sentences how a run ended before its time, if it did, and how it was coupled, if there are connections."""
    if not coupling.connections:
        return tuple(_ended(coupling))
    sentences = [
        *_ended(coupling),
        *(f"algebraic loop {loop}: {_closed(loop, coupling)}{_guarded(loop, coupling)}" for loop in coupling.loops),
        *_late(coupling),
        *_iterations(coupling),
        *_error(coupling),
        *(_energy(name, residual) for name, residual in coupling.energy_residual.items()),
        *(_guard(name, span) for name, span in coupling.guards.items()),
    ]
    return tuple(sentences)


def _ended(coupling: CouplingReport) -> list[str]:
    """Say which component has ended the run."""
    ended = coupling.ended
    if ended is None:
        return []
    sentence = f"{ended['component']} asked to end the simulation at t = {format_time(ended['time'])} s"
    return [f"{sentence}: {ended['reason']}" if ended["reason"] else sentence]


def _closed(loop: str, coupling: CouplingReport) -> str:
    """Say what has become of a loop."""
    unsolved = coupling.unsolved
    if unsolved is None:
        return f"{coupling.algorithm} passes on values of the step before"
    late = {name: found for name, found in (coupling.not_iterated or {}).items() if found["loop"] == loop}
    apart = [_apart(name, found) for name, found in late.items() if found["largest_difference"]]
    if apart:
        return f"not closed, as discrete values in it are not iterated: at the end of a step {', '.join(apart)}"
    accuracy = f"to {coupling.iteration_tolerance:g} of the values"
    if late:
        accuracy += ", and discrete ones in it, which are not iterated, agreed at the end of every step"
    first = unsolved["first"]
    if not unsolved["steps"] or first is None:
        return f"closed in every step, {accuracy}"
    return (
        f"not closed in {unsolved['steps']} of {count(coupling.steps, 'step')}, first at t = "
        f"{format_time(first)} s, by {unsolved['largest_residual']:.3g} at most; in the others {accuracy}"
    )


def _late(coupling: CouplingReport) -> list[str]:
    """Say what else was not iterated, and how far its ends lay apart."""
    return [
        f"discrete values are not iterated but a step late: at the end of a step {_apart(name, found)}"
        for name, found in (coupling.not_iterated or {}).items()
        if found["loop"] is None and found["largest_difference"]
    ]


def _apart(connection: str, found: NotIterated) -> str:
    """Say how far the ends of a connection lay apart."""
    when = "" if found["time"] is None else f" (t = {format_time(found['time'])} s)"
    return f"{connection.replace(' -> ', ' and ')} differ by {found['largest_difference']:.3g} at most{when}"


def _guarded(loop: str, coupling: CouplingReport) -> str:
    """Say which guards and limits stood in for a solution of a loop."""
    components = {name.partition(".")[0] for name in loop.split(" -> ")}
    names = [name for name in coupling.guards if name.partition(".")[0] in components]
    if coupling.iterations is None or not names:
        return ""
    return f"; where {' or '.join(names)} is on, by the value of that guard or limit and not by a solution"


def _iterations(coupling: CouplingReport) -> list[str]:
    """Say how often steps were repeated."""
    found = coupling.iterations
    if found is None:
        return []
    return [
        f"components of a loop were stepped {found['mean']:.2f} times a step, at most {count(found['most'], 'time')}"
    ]


def _error(coupling: CouplingReport) -> list[str]:
    """Say what is known of the error, and how many steps it cost."""
    found = coupling.error_estimate
    rejected = [] if coupling.rejected is None else [count(coupling.rejected, "step") + " rejected"]
    if found is None:
        return [*rejected, "error of the coupling not estimated (a tolerance asks for it)"]
    if found["largest"] is None or found["mean"] is None:
        text = "error of the coupling unknown, as nothing is passed on that could be compared"
    else:
        text = (
            f"estimated error {found['largest']:.2g} in a step at most, {found['mean']:.2g} on average, relative to "
            "values and nominal values"
        )
    text += f"; {', '.join([f'tolerance {coupling.tolerance:g}', *rejected])}"
    if found["beyond_tolerance"]:
        steps = count(coupling.steps, "step")
        text += f"; {found['beyond_tolerance']} of {steps} beyond the tolerance at the smallest size"
    return [text, *_not_estimated(found["not_estimated"])]


def _not_estimated(named: NotEstimated) -> list[str]:
    """Say what an estimate does not cover."""
    reasons = ((named["discrete"], "discrete"), (named["components"], "passes on nothing that is compared"))
    told = [f"{', '.join(names)} ({why})" for names, why in reasons if names]
    return [f"error not estimated of {', nor of '.join(told)}"] if told else []


def _energy(name: str, residual: EnergyResidual) -> str:
    """Say how much energy the coupling made or lost."""
    made = residual["sum"]
    what = "made" if made > 0.0 else "lost"
    text = f"energy {what} by the coupling at {name}: {abs(made):.3g} J of {residual['exchanged']:.3g} J exchanged"
    discrete = residual.get("discrete")
    return f"{text}, if {', '.join(discrete)} went on straight lines, not in steps" if discrete else text


def _guard(name: str, span: GuardSpan) -> str:
    """Say where values are a guard's or a limit's."""
    return (
        f"{name} is on at {count(span['points'], 'communication point')} from t = {format_time(span['first'])} s to "
        f"{format_time(span['last'])} s: values there are its own, not solutions"
    )


def count(number: int, what: str) -> str:
    """Write how many there are of something."""
    return f"{number} {what}" if number == 1 else f"{number} {what}s"
