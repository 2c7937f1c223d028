"""The bit: the down-going wave is incident, dry friction holds or drags, the up-going wave is outgoing.

    I_B dv/dt = 2 Z D(t - Gamma) - (Z + c_b) v - W R_b mu_b(v) sgn v
    U_b(t)    = v(t) - D(t - Gamma)

At v = 0 the dry friction is any torque up to W R_b mu_sb: the bit stays stuck while |2 Z D(t - Gamma)| does not exceed
it.
"""

from __future__ import annotations

from typing import Any

from ..numerics.collocation import NODES, WEIGHTS
from ..numerics.quartic import (
    NONE,
    ZERO,
    Quartic,
    end_value,
    extremes,
    first_positive,
    integral,
    restrict,
    subtract,
    value,
)
from .clock import SNAP, Clock, Ramp
from .delay_line import NOTHING, DelayLine
from .slip import GREATEST_STIFFNESS, Accuracy, BitLaw, collocate
from .work import HALVING, PIECE, SAVED, START_RATE, TooMuchWorkError

SHORTEST_SLIP = 1e-9
"""A release that would stop again within this part of a piece is none: the bit stays stuck."""

MOST_HALVINGS = 30
"""More halvings are not made."""

LOOSEST = 10.0
"""Greatest factor by which the truncation asked for is loosened where strong breaks are folded: beyond, the energy
that the bit gains would no longer be what the waves bring."""


class Bit:
    """The bit boundary condition, always one piece ahead: the piece that holds the present.

    Attributes
    ----------
    block, begin, end : int, float, float
        The piece: its block and its fractions of the block.
    direction : int
        1 or -1 while the bit slips that way, 0 while it is stuck.
    incident, turning : Quartic
        D(t - Gamma) and v(t) on the piece [rad/s].
    speed : float
        Bit speed at `begin` [rad/s].
    wob : Ramp
        The weight on bit as it was set [N].
    weight, weight_rise : float
        Weight on bit at `begin` and its rise over the piece [N].
    stops : bool
        The piece ends because the bit comes to rest there.
    releases : int
        Direction in which the bit breaks loose at the end of the piece, 0 if it does not.
    halted : bool
        The last piece ended at rest, and it is not yet decided whether the bit sticks.
    roughness : float
        How hard the speed over the piece is to follow; a piece above 1 is halved.
    truncation : float
        What is asked of the piece [rad/s]; more when breaks are folded that matter.
    whole : bool
        The piece is as long as it was integrated: `power` holds for it.
    power : float
        Integral of bit_torque times bit_speed over the piece as it was integrated, per unit of x [W].
    angle, loss, stuck : float
        Angle turned [rad], energy lost [J], time stuck [s] up to `begin`.
    earning : float
        Work that following it may take in a second, in blocks: see `models.plant.work` [1/s].
    credit : float
        Work that it may still take; it grows by `earning`, up to what a while brings.
    """

    __slots__ = (
        "accuracy", "angle", "begin", "block", "clock", "credit", "direction", "earning", "end", "halted", "incident",
        "incoming", "last_release", "last_stop", "law", "loss", "power", "releases", "roughness", "slips", "speed",
        "stops", "stuck", "truncation", "turning", "weight", "weight_rise", "whole", "wob",
    )  # fmt: skip

    def __init__(self, law: BitLaw, clock: Clock, speed: float, wob: Ramp) -> None:
        self.law = law
        self.clock = clock
        self.accuracy = Accuracy.on(clock)
        self.block = 0
        self.begin = self.end = 0.0
        self.direction = 1 if speed > 0.0 else -1 if speed < 0.0 else 0
        self.incident = self.turning = ZERO
        self.incoming = NOTHING
        self.speed = speed
        self.wob = wob
        self.weight = self.weight_rise = 0.0
        self.stops = self.halted = self.whole = False
        self.releases = 0
        self.truncation = self.roughness = self.power = 0.0
        self.angle = self.loss = self.stuck = 0.0
        self.last_stop = self.last_release = clock.start
        self.slips = 0
        self.endow(START_RATE)

    def endow(self, earning: float) -> None:
        """Let the bit earn so much a second, and begin with what it can save of them."""
        self.earning = earning
        self.credit = SAVED * earning

    def earn(self, work: float) -> None:
        """Add to the credit, as far as it can be saved."""
        self.credit = min(self.credit + work, SAVED * self.earning)

    def require_credit(self) -> None:
        """Refuse to follow the bit any further where its credit is spent."""
        if self.credit < 0.0:
            raise TooMuchWorkError(self.clock.time(self.block, self.begin))

    def open(self, down: DelayLine) -> None:
        """Take up the next piece: to the end of the incident piece, or to the first stop or release in it."""
        if self.begin >= self.incoming[1]:
            self.incoming = down.pop()
            self.begin = self.incoming[0]
        self.end = self.incoming[1]
        first, last, wave, _ = self.incoming
        self.incident = restrict(wave, (self.begin - first) / (last - first), 1.0)
        self.weight, self.weight_rise = self.wob.over(self.clock, self.block, self.begin, self.end)
        self.stops = False
        # hardly anything need be followed closer than the breaks that are folded
        asked = self.accuracy.truncation
        self.truncation = min(max(asked, down.threshold()), LOOSEST * asked)
        if self.speed == 0.0:
            self.direction = 0  # whatever it was about to do, inputs may have changed since
            self._rest()
        else:
            self._slip()
        self.halted = False

    def close(self, up: DelayLine) -> None:
        """Send the wave of the piece up the string and go to its end."""
        up.push(self.begin, self.end, subtract(self.turning, self.incident))
        self.finish()

    def finish(self) -> None:
        """Go to the end of the piece."""
        duration = (self.end - self.begin) * self.clock.block
        if self.direction == 0:
            self.stuck += duration
        else:
            self.angle += duration * integral(self.turning, 1.0)
            self.loss += duration * (self.power if self.whole else self.power_integral(1.0))
            self.speed = end_value(self.turning)
        if self.stops:
            self.speed = 0.0
            self.direction = 0
            self.halted = True
        self.earn(self.earning * duration - PIECE)
        self.begin = self.end
        if self.end >= 1.0:
            self.block += 1
            self.begin = 0.0
            self.incoming = NOTHING

    def cut(self, fraction: float) -> bool:
        """End the piece at a fraction of the block, because weight or friction change; False if it begins there anyway.

        The piece is then to be closed, and in any case a new one to be opened.
        """
        if not fraction - self.begin > SNAP:
            return False
        if self.end - fraction > SNAP:
            self._shorten((fraction - self.begin) / (self.end - self.begin), fraction)
            self.stops = False
            self.releases = 0
        return True

    def torque(self, x: float) -> float:
        """Return the torque on bit at x of the piece; the reaction of the rock while the bit is stuck [N m]."""
        law = self.law
        if self.direction == 0:
            return law.twice_impedance * value(self.incident, x)
        speed = value(self.turning, x)
        _, dry, _ = law.friction.at(self.weight + x * self.weight_rise, self.direction * speed)
        return law.viscosity * speed + dry * self.direction

    def power_integral(self, x: float) -> float:
        """Return the integral of bit_torque times bit_speed from 0 to x of the piece, per unit of x [W] (Lobatto)."""
        if self.direction == 0:
            return 0.0
        total = 0.0
        for node, weight in zip(NODES, WEIGHTS, strict=True):
            total = total + weight * (self.torque(node * x) * value(self.turning, node * x))
        return x * total

    def extremes(self, x0: float, x1: float) -> tuple[float, float]:
        """Return the least and greatest bit speed between x0 and x1 of the piece [rad/s]."""
        if self.direction == 0:
            return 0.0, 0.0
        low, high = extremes(self.turning, x0, x1)
        if self.direction > 0:  # where it comes to rest, rounding may leave it beyond
            return (low if low > 0.0 else 0.0), high
        return low, (high if high < 0.0 else 0.0)

    def _rest(self) -> None:
        """Keep the bit stuck up to the end of the piece or its release; at a release, begin to slip."""
        over, below = self._excess_torque()
        ahead = first_positive(over)
        back = first_positive(below)
        x = ahead if ahead <= back else back
        if self.releases != 0 or x < SHORTEST_SLIP:
            self.direction = self.releases if self.releases != 0 else 1 if ahead <= back else -1
            self.releases = 0
            self._slip()
            if self.direction != 0:
                self._count_release()
                return
            x = NONE
        if self.halted:
            self.last_stop = self.clock.time(self.block, self.begin)
        self.turning = ZERO
        self.releases = 0
        if x < 1.0:
            self._shorten(x, self.begin + x * (self.end - self.begin))
            self.releases = 1 if ahead <= back else -1

    def _count_release(self) -> None:
        """Count a release, but not a passage through rest, nor one again that is decided anew."""
        time = self.clock.time(self.block, self.begin)
        if not self.halted and (self.slips == 0 or time != self.last_release):
            self.last_release = time
            self.slips += 1

    def _excess_torque(self) -> tuple[Quartic, Quartic]:
        """Return by how much the torque on the stuck bit exceeds the static friction ahead and back [N m]."""
        z = self.law.twice_impedance
        a0, a1, a2, a3, a4 = self.incident
        static = self.law.friction.static * self.weight
        rise = self.law.friction.static * self.weight_rise
        ahead = (z * a0 - static, z * a1 - rise, z * a2, z * a3, z * a4)
        back = (-(z * a0) - static, -(z * a1) - rise, -(z * a2), -(z * a3), -(z * a4))
        return ahead, back

    def _slip(self) -> None:
        """Integrate the bit equation over the piece, or up to the place where the bit comes to rest."""
        halvings = 0
        self._collocate(last_try=False)
        while halvings < MOST_HALVINGS and not self.roughness <= 1.0:
            halvings += self._halve(MOST_HALVINGS - halvings)
            self._collocate(last_try=halvings == MOST_HALVINGS)
        t0, t1, t2, t3, t4 = self.turning
        x = first_positive((-t0, -t1, -t2, -t3, -t4) if self.direction > 0 else self.turning)
        if x > 1.0:
            return
        if self.speed == 0.0 and x < SHORTEST_SLIP:
            self.direction = 0
            return
        self._shorten(x, self.begin + x * (self.end - self.begin))
        self.stops = True

    def _halve(self, most: int) -> int:
        """Halve the piece, again while its begin shows that it is too rough, at most so often; return how often."""
        law = self.law
        _, _, dry_slope = law.friction.at(self.weight, self.direction * self.speed)
        derivative = -dry_slope - law.damping
        end, x, count = self.end, 1.0, 0
        while count < most:
            end = self.begin + 0.5 * (end - self.begin)
            x = 0.5 * x
            count += 1
            duration = (end - self.begin) * self.clock.block
            if not abs(duration / law.inertia * derivative) / GREATEST_STIFFNESS > 1.0:
                break
        self._shorten(x, end)
        self.credit = self.credit - HALVING
        return count

    def _collocate(self, *, last_try: bool) -> None:
        """Integrate the bit equation over the piece as it is."""
        duration = (self.end - self.begin) * self.clock.block
        dry = (self.weight, self.weight_rise)
        accuracy = Accuracy(self.truncation, self.accuracy.newton)
        slip = collocate(self.law, accuracy, self.direction, duration, self.speed, self.incident, dry, last_try)
        self.turning, self.power, self.roughness, work = slip
        self.credit = self.credit - work
        self.whole = True

    def _shorten(self, x: float, fraction: float) -> None:
        """End the piece at x, which is at `fraction` of the block."""
        self.incident = restrict(self.incident, 0.0, x)
        self.turning = restrict(self.turning, 0.0, x)
        self.weight_rise = x * self.weight_rise
        self.end = fraction
        self.whole = False

    def state(self) -> dict[str, Any]:
        """Return everything that changes in time, as plain data."""
        return {name: getattr(self, name) for name in self.__slots__ if name not in _CONSTANT}

    def restore(self, state: dict[str, Any]) -> None:
        """Take a state of :meth:`state` back."""
        for name, content in state.items():
            setattr(self, name, content)
        self.wob = Ramp(*state["wob"])


_CONSTANT = frozenset({"accuracy", "clock", "earning", "law"})
