"""A driller that feeds the string so that the weight on bit is as asked for, and a bit that drills."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple


class Drilling(NamedTuple):
    """State of the weight and of the controller that feeds the string.

    Attributes
    ----------
    weight : float
        On the bit [N].
    depth : float
        Drilled since the start [m].
    integral : float
        Of the controller [m/s].
    feed : float
        Speed at which the string has been fed in the last step [m/s].
    engaged : float
        1 if the controller feeds; else the feed stays as it is.
    limited : float
        1 while the feed or the weight is at a limit.
    """

    weight: float
    depth: float
    integral: float
    feed: float
    engaged: float
    limited: float


@dataclass(frozen=True)
class Autodriller:
    """The weight of a string that is fed at its top while the bit drills.

    Attributes
    ----------
    stiffness : float
        E A / L of the string [N/m].
    drillability : float
        a: depth per angle and weight above the threshold [m/(N rad)].
    threshold : float
        W_0 [N].
    proportional, reset_time : float
        Gain [m/(N s)] and integral time [s] of the controller.
    greatest_feed, greatest_weight : float
        Limits [m/s, N]; the least weight is 0.
    least_feed : float
        Limit [m/s]; less than 0 where the driller may lift the string.
    """

    stiffness: float
    drillability: float
    threshold: float
    proportional: float
    reset_time: float
    greatest_feed: float
    greatest_weight: float
    least_feed: float = 0.0

    def rate(self, weight: float, bit_speed: float) -> float:
        """Return the rate of penetration a (W - W_0) v [m/s]; 0 below the threshold and while the bit turns back."""
        if weight <= self.threshold or bit_speed <= 0.0:
            return 0.0
        return self.drillability * (weight - self.threshold) * bit_speed

    def begin(self, weight: float, bit_speed: float, engaged: bool) -> Drilling:
        """Return the state in which the string is fed as fast as the bit drills."""
        feed = self.rate(weight, bit_speed)
        limited = feed > self.greatest_feed
        feed = self.greatest_feed if limited else feed
        return Drilling(weight, 0.0, feed, feed, float(engaged), float(limited))

    def advance(self, before: Drilling, weight_ref: float, bit_speed: float, enabled: bool, elapsed: float) -> Drilling:
        """Return the state after `elapsed` seconds of a constant feed, which is chosen at their beginning.

        Parameters
        ----------
        weight_ref, bit_speed : float
            What is asked for [N], and the speed of the bit [rad/s], in the middle of the step.
        enabled : bool
            Whether the controller feeds.
        """
        error = weight_ref - before.weight
        integral, feed = before.integral, before.feed
        if not enabled or before.engaged == 0.0:
            integral = feed - self.proportional * error
        wanted = self.proportional * error + integral if enabled else feed
        least, most = self.least_feed, self.greatest_feed
        feed = most if wanted > most else least if wanted < least else wanted
        if enabled and not ((wanted > most and error > 0.0) or (wanted < least and error < 0.0)):
            integral = integral + self.proportional / self.reset_time * elapsed * error
        share = 0.0
        if before.weight > self.threshold and bit_speed > 0.0:
            share = 0.5 * elapsed * self.stiffness * self.drillability * bit_speed
        # the trapezoidal rule for the weight above its threshold, from which the rate of penetration follows
        above = before.weight - self.threshold
        above = (above * (1.0 - share) + elapsed * self.stiffness * feed) / (1.0 + share)
        weight = above + self.threshold
        held = self.greatest_weight if weight > self.greatest_weight else 0.0 if weight < 0.0 else weight
        drilled = 0.5 * elapsed * (self.rate(before.weight, bit_speed) + self.rate(held, bit_speed))
        limited = float(feed != wanted or held != weight)
        return Drilling(held, before.depth + drilled, integral, feed, float(enabled), limited)
