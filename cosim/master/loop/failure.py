"""Saying that a loop has no solution: when, between which variables, how far off, and what to try."""

from __future__ import annotations

from collections.abc import Callable, Collection

import numpy as np

from cosim.errors import LoopError, format_time
from cosim.master.loop.coupled import CoupledLoop
from cosim.master.loop.trials import Trial, UnsolvedError
from cosim.master.stepping.channel import Channel
from cosim.system.dependency import Loop

_REMEDY = (
    "Try other parameters, a component with a delay of its own in the loop, or another on_failure: halve for smaller "
    "steps, explicit to go on with values from the beginning of the step"
)
# A jump less than this, relative to the nominal value, may be the accuracy of an FMU and not a property of its model.
_ACCURACY = 1e-4


def reporter(
    loops: Collection[Loop], guards: Callable[[int], Collection[str]]
) -> Callable[[CoupledLoop, UnsolvedError, int, float], LoopError]:
    """Return what puts failures of loops into words.

    Parameters
    ----------
    loops : collection of Loop
        The algebraic loops of the system.
    guards : callable
        From a row of the stage to the names of the guards and limits that are active there.
    """

    def explain(loop: CoupledLoop, failure: UnsolvedError, row: int, time: float) -> LoopError:
        worst = int(np.argmax(np.abs(failure.best.residual)))
        channel = loop.torn[worst]
        path = _path(loop, channel, loops)
        residual = abs(float(failure.best.residual[worst])) * channel.nominal
        names = [name for name in guards(row) if name.partition(".")[0] in {part.name for part in loop.parts}]
        active = f"; {' and '.join(names)} {'is' if len(names) == 1 else 'are'} on there" if names else ""
        sentence = (
            f"t = {format_time(time)} s: {' -> '.join((*path, path[0]))} {_verdict(failure, channel, worst)}{active}. "
            f"The least residual of {failure.trials} trials is {_quantity(residual, channel)}. {_REMEDY}"
        )
        return LoopError(sentence, time, path, residual, failure.trials)

    return explain


def _path(loop: CoupledLoop, channel: Channel, loops: Collection[Loop]) -> tuple[str, ...]:
    """Name the loop: the algebraic one that holds the connection, or else the connections that were tried."""
    for known in loops:
        if channel.target.name in known.variables:
            return known.path
    others = [other for other in loop.torn if other is not channel]
    return tuple(name for one in (channel, *others) for name in (one.source, one.target.name))


def _verdict(failure: UnsolvedError, channel: Channel, index: int) -> str:
    """Say why there is no solution, or that none was found."""
    if failure.jump is None:
        tried = _quantity(float(failure.best.values[index]) * channel.nominal, channel)
        return f"does not close: no solution was found, the nearest was {channel.target.name} = {tried}"
    low, high = failure.jump
    place = _quantity(float(low.values[0]) * channel.nominal, channel)
    below, above = (_quantity(_answer(trial, channel), channel) for trial in (low, high))
    if max(low.miss, high.miss) < _ACCURACY:
        return f"closes only as well as its components compute: round {channel.target.name} = {place}"
    return (
        f"has no solution: where {channel.target.name} passes {place}, {channel.source} jumps from {below} to {above}"
    )


def _answer(trial: Trial, channel: Channel) -> float:
    """Return what came back, in the unit of the variable."""
    return float(trial.values[0] + trial.residual[0]) * channel.nominal


def _quantity(value: float, channel: Channel) -> str:
    """Write a value with its unit."""
    unit = channel.target.variable.unit
    return f"{value:.6g} {unit.name}" if unit is not None and unit.name != "1" else f"{value:.6g}"
