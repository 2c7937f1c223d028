"""Comparing the units at the two ends of a connection."""

from __future__ import annotations

from enum import Enum

from cosim.system.description import Unit

BASE_UNITS = ("kg", "m", "s", "A", "K", "mol", "cd", "rad")


class Match(Enum):
    """How two units compare."""

    SAME = "same"
    UNKNOWN = "unknown"
    SCALED = "scaled"
    DIFFERENT = "different"


def compare(source: Unit | None, target: Unit | None) -> Match:
    """Compare two units by their powers of the base units and, failing those, by name.

    Returns
    -------
    Match
        `UNKNOWN` if one unit is missing, or if the names differ and one of them is not defined in base units;
        `SCALED` if only factor or offset differ.
    """
    if source is None or target is None:
        return Match.SAME if source is target else Match.UNKNOWN
    if source.powers is None or target.powers is None:
        return Match.SAME if source.name == target.name else Match.UNKNOWN
    if source.powers != target.powers:
        return Match.DIFFERENT
    same = source.factor == target.factor and source.offset == target.offset
    return Match.SAME if same else Match.SCALED


def describe(unit: Unit | None) -> str:
    """Write a unit with what it is in base units, for a message."""
    if unit is None:
        return "no unit"
    if unit.powers is None:
        return unit.name
    names = zip(BASE_UNITS, unit.powers, strict=True)
    base = " ".join(name if power == 1 else f"{name}^{power}" for name, power in names if power) or "1"
    factor = "" if unit.factor == 1.0 else f"{unit.factor:.15g} "
    offset = "" if unit.offset == 0.0 else f" + {unit.offset:.15g}"
    return f"{unit.name} (= {factor}{base}{offset})"
