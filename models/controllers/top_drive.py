"""A rotary drive with what real ones have: lag, inertia, limits of torque and power, sampling, delay, noisy sensors."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, NamedTuple

from ..numerics.low_pass import fading
from ..numerics.noise import normal

LONGEST_QUEUE = 64
"""Sample times by which commands can be delayed."""
MOST_SAMPLES = 1e6
"""In one step."""
ON_TIME = 1e-6
"""A sample within this part of the sample time before the end of a step is taken at it: times are rounded."""


class Signals(NamedTuple):
    """Inputs at an instant: what is asked for, and torque and speed at the top of the string."""

    speed: float
    motor_torque: float
    top_torque: float
    top_speed: float


class DriveState(NamedTuple):
    """State of a drive.

    Attributes
    ----------
    speed : float
        Omega [rad/s], without `over`.
    motor : float
        Torque of the motor since the last sample [N m].
    command : float
        Speed it goes to, of mode servo as far as it may change [rad/s].
    integral : float
        Of the speed controller [N m].
    left : float
        Time to the next sample [s].
    limited : float
        1 while the motor is at its greatest torque or power, -1 at its least, else 0.
    over : float
        By how much a drive of mode speed, at its least torque, is faster than asked for [rad/s].
    random : float
        State of the noise.
    seen_speed, seen_torque, seen_top : float
        Omega, top_torque and top_speed as the sensors have shown them last.
    place : float
        Of the oldest command in the queue.
    queue : tuple of float
        Commands that are under way.
    """

    speed: float
    motor: float
    command: float
    integral: float
    left: float
    limited: float
    over: float
    random: float
    seen_speed: float
    seen_torque: float
    seen_top: float
    place: float
    queue: tuple[float, ...]

    @classmethod
    def of(cls, flat: tuple[float, ...]) -> DriveState:
        """Return the state that was made flat."""
        return cls._make((*flat[:12], flat[12:]))

    def flat(self) -> tuple[float, ...]:
        """Return the state as numbers, the queue at their end."""
        seen = (self.seen_speed, self.seen_torque, self.seen_top)
        first = (self.speed, self.motor, self.command, self.integral, self.left, self.limited, self.over, self.random)
        return (*first, *seen, self.place, *self.queue)

    @property
    def turning(self) -> float:
        """Speed of the drive, Omega [rad/s]."""
        return self.speed + self.over


@dataclass(frozen=True)
class TopDrive:
    """A drive that follows a speed or gives a torque.

    Attributes
    ----------
    mode : {"speed", "servo", "torque"}
        A speed behind a lag; a rotor with a speed controller; a rotor alone.
    lag, rate : float
        Time constant of mode speed [s]; change of speed, or of its set point, at most [rad/s^2].
    inertia, proportional, integral : float
        Of the rotor [kg m^2], and gains of its controller [N m s/rad, N m/rad].
    least, greatest, power : float
        Limits of the motor's torque [N m] and power [W].
    sample_time, delay : float
        Between samples, and until a command acts [s].
    speed_noise, torque_noise : float
        Standard deviations of what the sensors show [rad/s, N m].
    """

    mode: Literal["speed", "servo", "torque"]
    lag: float
    rate: float
    inertia: float
    proportional: float
    integral: float
    least: float
    greatest: float
    power: float
    sample_time: float
    delay: float
    speed_noise: float
    torque_noise: float

    def begin(self, now: Signals, seed: int) -> DriveState:
        """Return the state of a drive that has turned at the speed asked for, with sensors that are right."""
        asked = now.motor_torque if self.mode == "torque" else now.top_torque
        motor = self._within(asked, self._highest(now.speed))
        command = now.motor_torque if self.mode == "torque" else now.speed
        return DriveState(
            now.speed, motor, now.speed, motor, self.sample_time, _beyond(asked, motor), 0.0, float(seed), now.speed,
            now.top_torque, now.top_speed, 0.0, (command,) * LONGEST_QUEUE,
        )  # fmt: skip

    def advance(self, state: DriveState, begin: Signals, slopes: Signals, elapsed: float) -> DriveState:
        """Return the state after `elapsed` seconds, in which the inputs go from `begin` along slopes.

        Raises
        ------
        ValueError
            The step holds too many samples.
        """
        if elapsed > MOST_SAMPLES * self.sample_time:
            raise ValueError(f"a step of {elapsed!r} s has more than 1e+06 samples; expected fewer")
        done = 0.0
        while elapsed - done >= state.left - ON_TIME * self.sample_time:
            part = state.left
            state = self._sampled(self._moved(state, begin, slopes, done, part), _at(begin, slopes, done + part))
            done = done + part
        rest = elapsed - done
        if rest > 0.0:
            state = self._moved(state, begin, slopes, done, rest)
        return state._replace(left=state.left - rest)

    def _moved(self, state: DriveState, begin: Signals, slopes: Signals, done: float, part: float) -> DriveState:
        """Return the state after a part of a step between samples."""
        torque = begin.top_torque + slopes.top_torque * (done + 0.5 * part)
        turned = state.turning + part * (state.motor - torque) / self.inertia
        if self.mode != "speed":
            return state._replace(speed=turned)
        speed = self._followed(state.speed, state.command, part)
        if state.limited > 0.0:
            return state._replace(speed=turned if turned < speed else speed)
        over = turned - speed if state.limited < 0.0 and turned > speed else 0.0
        return state._replace(speed=speed, over=over)

    def _followed(self, speed: float, command: float, part: float) -> float:
        """Return a speed that has followed a command, at most at the rate."""
        gap = command - speed
        reach = self.rate * self.lag
        if gap > reach or gap < -reach:
            climb = self.rate if gap > 0.0 else -self.rate
            until = (gap - climb * self.lag) / climb
            if until >= part:
                return speed + climb * part
            gap = climb * self.lag
            part = part - until
        return command - gap * fading(part, self.lag)

    def _sampled(self, state: DriveState, now: Signals) -> DriveState:
        """Return the state after a sample: sensors read, and the motor set."""
        state = self._seen(state, now)
        asked, state = self._arrived(state, now.motor_torque if self.mode == "torque" else now.speed)
        highest = self._highest(state.turning)
        state = state._replace(left=self.sample_time)
        if self.mode == "speed":
            return self._strained(state, asked, now.top_torque, highest)
        if self.mode == "torque":
            motor = self._within(asked, highest)
            return state._replace(motor=motor, limited=_beyond(asked, motor))
        most = self.rate * self.sample_time
        change = asked - state.command
        command = state.command + (most if change > most else -most if change < -most else change)
        error = command - state.seen_speed
        integral = state.integral + self.integral * self.sample_time * error
        wanted = self.proportional * error + integral
        motor = self._within(wanted, highest)
        if (wanted > highest and error > 0.0) or (wanted < self.least and error < 0.0):
            integral = state.integral
        return state._replace(command=command, integral=integral, motor=motor, limited=_beyond(wanted, motor))

    def _seen(self, state: DriveState, now: Signals) -> DriveState:
        speed, torque, top, random = state.turning, now.top_torque, now.top_speed, state.random
        if self.speed_noise > 0.0:
            drawn, random = normal(random)
            speed = speed + self.speed_noise * drawn
            drawn, random = normal(random)
            top = top + self.speed_noise * drawn
        if self.torque_noise > 0.0:
            drawn, random = normal(random)
            torque = torque + self.torque_noise * drawn
        return state._replace(seen_speed=speed, seen_torque=torque, seen_top=top, random=random)

    def _arrived(self, state: DriveState, command: float) -> tuple[float, DriveState]:
        """Return the command that arrives as another sets out."""
        length = self.queue_length
        if length == 0:
            return command, state
        place = int(state.place)
        asked = state.queue[place]
        queue = (*state.queue[:place], command, *state.queue[place + 1 :])
        return asked, state._replace(queue=queue, place=float((place + 1) % length))

    @property
    def queue_length(self) -> int:
        """Sample times from a command to when it acts."""
        return int(self.delay / self.sample_time + 0.5)

    def _strained(self, state: DriveState, asked: float, torque: float, highest: float) -> DriveState:
        """Return the state in which the motor gives what the string takes, as far as it can.

        Beyond, the speed is that of the rotor: a greater torque slows it down, and it sets out anew from there; a
        string that would have to be braked turns it faster, and at its least torque it falls back to what is asked for.
        """
        loose = torque < self.least or state.over > 0.0
        motor = self.least if loose else self._within(torque, highest)
        limited = -1.0 if loose else _beyond(torque, motor)
        return state._replace(command=asked, motor=motor, limited=limited)

    def _highest(self, speed: float) -> float:
        """Return the greatest torque at a speed."""
        size = speed if speed >= 0.0 else -speed
        return self.power / size if size * self.greatest > self.power else self.greatest

    def _within(self, torque: float, highest: float) -> float:
        return highest if torque > highest else self.least if torque < self.least else torque


def _at(begin: Signals, slopes: Signals, elapsed: float) -> Signals:
    return Signals(*(value + slope * elapsed for value, slope in zip(begin, slopes, strict=True)))


def _beyond(asked: float, motor: float) -> float:
    """Return 1 if more was asked of the motor than it gives, -1 if less, else 0."""
    return 1.0 if asked > motor else -1.0 if asked < motor else 0.0
