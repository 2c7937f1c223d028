"""Lay a system out as a diagram: components below each other, and arrows between them with the names of signals.

Components stand in the order in which values pass down. An arrow to the next one below goes straight; one that skips
components goes down on the right, and one that leads back goes up on the left, each in a lane of its own, so that no
name lies over another. Lengths are in pixels of an SVG.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise

_LETTER, _LINE = 7.4, 16.0
"""Width of a letter and height of a line, at 12 pixels a letter."""
_PAD, _GAP = 12.0, 26.0
_LANE = 20.0
"""Between a lane and the names of the one within."""
_LONGEST = 44
"""Letters of a name; more are cut, and the table beside has all."""


_MOST_COMPONENTS, _MOST_WAYS = 60, 200
"""In a diagram that anybody reads."""


@dataclass(frozen=True)
class Wire:
    """Everything that one component passes on to another.

    Attributes
    ----------
    source, target : str
        Names of components.
    signals : tuple of str
        What is passed on, one line each.
    looped : bool
        Whether any of it is part of an algebraic loop.
    """

    source: str
    target: str
    signals: tuple[str, ...]
    looped: bool


@dataclass(frozen=True)
class Box:
    """A component, with its place.

    Attributes
    ----------
    name : str
        Of the component.
    lines : tuple of str
        Text below the name: the FMU's name, and what drives inputs from outside.
    x, y, width, height : float
        Its place.
    """

    name: str
    lines: tuple[str, ...]
    x: float
    y: float
    width: float
    height: float


@dataclass(frozen=True)
class Arrow:
    """An arrow, with the place of its names.

    Attributes
    ----------
    way : Wire
        What it passes on.
    path : str
        Of the line, as SVG writes it.
    x, y : float
        Where the first name stands.
    anchor : str
        Which end of the names is there, ``"start"`` or ``"end"``.
    """

    way: Wire
    path: str
    x: float
    y: float
    anchor: str


@dataclass(frozen=True)
class Diagram:
    """Boxes and arrows, and the size of all."""

    boxes: tuple[Box, ...]
    arrows: tuple[Arrow, ...]
    width: float
    height: float


def ways(components: Sequence[str], connections: Sequence[str], loops: Sequence[str]) -> tuple[Wire, ...]:
    """Gather connections, written ``a.x -> b.y``, by the components they lead from and to; others are left out."""
    turns = [step for loop in loops for step in _steps(loop)]
    found: dict[tuple[str, str], list[tuple[str, bool]]] = {}
    for connection in connections:
        for source, target in _steps(connection):
            ends = _component(source, components), _component(target, components)
            if ends[0] is None or ends[1] is None:
                continue
            passed, taken = source[len(ends[0]) + 1 :], target[len(ends[1]) + 1 :]
            text = passed if passed == taken else f"{passed} → {taken}"
            found.setdefault((ends[0], ends[1]), []).append((text, (source, target) in turns))
    return tuple(
        Wire(*ends, tuple(text for text, _ in signals), any(looped for _, looped in signals))
        for ends, signals in found.items()
    )


def _steps(path: str) -> list[tuple[str, str]]:
    """Take a path apart into its steps."""
    ports = path.split(" -> ")
    return list(pairwise(ports))


def _component(port: str, components: Sequence[str]) -> str | None:
    """Return whose port it is; names may have dots."""
    fitting = [name for name in components if port.startswith(f"{name}.")]
    return max(fitting, key=len, default=None)


def in_order(components: Sequence[str], found: Sequence[Wire]) -> list[str]:
    """Put components into an order in which few ways lead back: next comes what most of its sources stand above of."""
    placed: list[str] = []
    while len(placed) < len(components):
        left = [name for name in components if name not in placed]
        waiting = {name: sum(w.target == name != w.source and w.source in left for w in found) for name in left}
        fed = {name: sum(w.target == name and w.source in placed for w in found) for name in left}
        placed.append(min(left, key=lambda name: (waiting[name], -fed[name])))
    return placed


def lay_out(texts: Mapping[str, Sequence[str]], found: Sequence[Wire]) -> Diagram | None:
    """Lay out components, each with the lines of its box, and the ways between them; None of a system too large."""
    if len(texts) > _MOST_COMPONENTS or len(found) > _MOST_WAYS:
        return None
    order = in_order(list(texts), found)
    straight = {way.source: way for way in found if _follows(order, way)}
    width = max((_width([name, *lines]) for name, lines in texts.items()), default=0.0) + 2 * _PAD
    back = [way for way in found if order.index(way.source) >= order.index(way.target)]
    skipping = [way for way in found if way not in back and way not in straight.values()]
    left = sum(_width(way.signals) + _LANE for way in back) + (_PAD if back else 0.0)
    aside = max((_width(way.signals) + _LANE for way in straight.values()), default=0.0)
    right = max(0.0, aside - width / 2) if straight else 0.0
    boxes = _boxes(order, texts, straight, left, width)
    by_name = {box.name: box for box in boxes}
    arrows = [_down(by_name[way.source], by_name[way.target], way) for way in straight.values()]
    edge = left
    for number, way in enumerate(_innermost_first(back, order)):
        edge -= _LANE
        arrows.append(_aside(by_name, way, edge, number, left=True))
        edge -= _width(way.signals)
    edge = left + width + right
    for number, way in enumerate(_innermost_first(skipping, order)):
        edge += _LANE
        arrows.append(_aside(by_name, way, edge, number, left=False))
        edge += _width(way.signals)
    return Diagram(boxes, tuple(arrows), edge + _PAD, (boxes[-1].y + boxes[-1].height if boxes else 0.0) + _PAD)


def _follows(order: Sequence[str], way: Wire) -> bool:
    """Tell whether a way leads to the next component below."""
    return order.index(way.target) == order.index(way.source) + 1


def _innermost_first(found: Sequence[Wire], order: Sequence[str]) -> list[Wire]:
    """Sort ways so that short ones have inner lanes."""
    return sorted(found, key=lambda way: abs(order.index(way.source) - order.index(way.target)))


def _boxes(
    order: Sequence[str], texts: Mapping[str, Sequence[str]], straight: Mapping[str, Wire], x: float, width: float
) -> tuple[Box, ...]:
    """Stack the boxes, with room between them for the names of what goes straight down."""
    y, boxes = _PAD, list[Box]()
    for name in order:
        height = _LINE * (1 + len(texts[name])) + 2 * _PAD
        boxes.append(Box(name, tuple(map(shortened, texts[name])), x, y, width, height))
        passed = len(straight[name].signals) if name in straight else 0
        y += height + _GAP + _LINE * max(1, passed)
    return tuple(boxes)


def _down(above: Box, below: Box, way: Wire) -> Arrow:
    """Lead from a box to the next below."""
    x, begin, end = above.x + above.width / 2, above.y + above.height, below.y
    middle = (begin + end) / 2 - _LINE * (len(way.signals) - 1) / 2 + _LINE / 4
    return Arrow(way, f"M{x:.1f} {begin:.1f}V{end - 1:.1f}", x + _PAD, middle, "start")


def _aside(boxes: Mapping[str, Box], way: Wire, lane: float, number: int, *, left: bool) -> Arrow:
    """Lead from a side of a box through a lane to the same side of another; each lane meets boxes at its own height."""
    source, target = boxes[way.source], boxes[way.target]
    x = source.x if left else source.x + source.width
    part = (number % 5) / 14
    begin, end = source.y + source.height * (0.85 - part), target.y + target.height * (0.15 + part)
    if not left:
        begin, end = source.y + source.height * (0.9 - part), target.y + target.height * (0.1 + part)
    gap = 1.0 if left else -1.0
    path = f"M{x:.1f} {begin:.1f}H{lane:.1f}V{end:.1f}H{x - gap:.1f}"
    middle = (begin + end) / 2 - _LINE * (len(way.signals) - 1) / 2 + _LINE / 4
    return Arrow(way, path, lane - 6 if left else lane + 6, middle, "end" if left else "start")


def _width(lines: Sequence[str]) -> float:
    """Return how wide lines are."""
    return max((len(shortened(line)) for line in lines), default=0) * _LETTER


def shortened(text: str) -> str:
    """Cut a text that is too long for the diagram."""
    return text if len(text) <= _LONGEST else text[: _LONGEST - 1] + "…"
