"""Telemetry from downhole as a pythonfmu slave."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from fmu_src.fmus.MudPulse.interface import MODEL
from fmu_src.python.law import Law
from models.controllers.telemetry import MOST_UNDER_WAY, Link
from models.controllers.telemetry import MudPulse as Telemetry

_MUD_PULSE, _WIRED_PIPE = 1, 2


class MudPulse(Law):
    """A value from downhole, late and coarse."""

    model = MODEL

    def check(self, values: Sequence[Any]) -> str | None:
        """Return that more frames are under way than can be kept."""
        link = self._telemetry(values)
        most = (MOST_UNDER_WAY - 2) * link.interval
        wanted = f"expected at most 254 times the time between frames, {most!r} s"
        return f"a frame takes {link.latency!r} s to arrive; {wanted}" if link.latency > most else None

    def begin(self, values: list[Any]) -> tuple[float, ...]:
        """Begin with the first sample."""
        return _flat(self._telemetry(values).begin(values[self.at["value"]], values[self.at["seed"]]))

    def advance(self, values: list[Any], elapsed: float) -> tuple[float, ...]:
        """Send and receive."""
        return _flat(self._telemetry(values).advance(_link(self.memory), values[self.at["value"]], 0.0, elapsed))

    def answer(self, memory: tuple[float, ...], values: list[Any]) -> None:
        """Answer with what has arrived."""
        telemetry, link = self._telemetry(values), _link(memory)
        values[self.at["measured"]] = link.measured
        values[self.at["age"]] = telemetry.age(link)
        values[self.at["valid"]] = telemetry.valid(link)
        values[self.at["limit_active"]] = link.limited != 0.0

    def tell_changes(self, before: list[Any], values: list[Any], time: float) -> None:
        """Say when values arrive and when one is lost."""
        at = self.at["valid"]
        if values[at] != before[at]:
            self.event(time, "values arrive" if values[at] else "a frame is lost")

    def _telemetry(self, values: Sequence[Any]) -> Telemetry:
        def of(name: str) -> Any:
            return values[self.at[name]]

        rate = {_MUD_PULSE: 10.0, _WIRED_PIPE: 57600.0}.get(of("link"), of("bit_rate"))
        transport = {_MUD_PULSE: of("L") / 1200.0, _WIRED_PIPE: 0.0}.get(of("link"), of("L") / of("wave_speed"))
        frame = (float(of("bits")) + of("overhead")) / rate
        steps = 1.0
        for _ in range(of("bits")):
            steps = steps * 2.0
        interval = of("sample_time") if of("sample_time") > frame else frame
        return Telemetry(interval, frame + transport, of("value_min"), of("range"), steps - 1.0, of("loss"))


def _flat(link: Link) -> tuple[float, ...]:
    return (link.clock, link.sent, link.due, link.measured, link.stamp, link.limited, link.random, *link.codes)


def _link(flat: tuple[float, ...]) -> Link:
    clock, sent, due, measured, stamp, limited, random, *codes = flat
    return Link(clock, sent, due, measured, stamp, limited, random, tuple(codes))
