"""The parameters of the drillstring, without and with damping along it, and the constants that follow from them."""

from __future__ import annotations

from dataclasses import dataclass
from math import isfinite, sqrt
from typing import ClassVar

from .clock import CELL_LIMIT, blocks_for
from .friction import FrictionParameters

MOST_STRENGTH = 0.125
"""Blocks are so short that a wave loses about this share of itself while it crosses one, at most."""


@dataclass(frozen=True)
class DrillstringParameters(FrictionParameters):
    """Parameters by the paper's symbols; the defaults are the paper's values.

    Source: Saldivar et al. (2011), eqs. (1) to (4) and section 3. ``I_B`` is not given in the paper; 89 kg m^2 is the
    value usual in the same group's work. Beside these there are the parameters of the friction, by keyword only.

    Parameters
    ----------
    G : float
        Shear modulus [Pa].
    J : float
        Geometrical moment of inertia [m^4].
    I : float
        Moment of inertia of the pipe per unit length [kg m].
    L : float
        Length [m].
    I_B : float
        Inertia of the bottom hole assembly [kg m^2].
    c_a : float
        Damping of the sliding top [N m s/rad].
    **friction : float
        ``c_b``, ``R_b``, ``mu_cb``, ``mu_sb``, ``gamma_b`` and ``v_f`` of
        :class:`models.plant.friction.FrictionParameters`.

    Raises
    ------
    ValueError
        A parameter is not finite or has the wrong sign, or mu_cb <= mu_sb <= 1 or gamma_b <= 1 do not hold.
    """

    G: float = 79.3e9
    J: float = 1.19e-5
    I: float = 0.095  # noqa: E741 (the paper's symbol)
    L: float = 1172.0
    I_B: float = 89.0
    c_a: float = 2000.0
    POSITIVE: ClassVar[frozenset[str]] = FrictionParameters.POSITIVE | {"G", "J", "I", "L", "I_B", "c_a"}

    @property
    def impedance(self) -> float:
        """Wave impedance Z = sqrt(I G J) [N m s/rad]."""
        return sqrt(self.I * self.G * self.J)

    @property
    def travel_time(self) -> float:
        """Time Gamma = L sqrt(I / (G J)) a wave takes along the string [s]."""
        return self.L * sqrt(self.I / (self.G * self.J))

    @property
    def reflection(self) -> float:
        """Top reflection Upsilon = (c_a - Z) / (c_a + Z), in (-1, 1)."""
        return (self.c_a - self.impedance) / (self.c_a + self.impedance)

    @property
    def transmission(self) -> float:
        """Share c_a / Lambda of the drive speed that enters the string, Lambda = c_a + Z, in (0, 1)."""
        return self.c_a / (self.c_a + self.impedance)

    @property
    def stiffness(self) -> float:
        """Torque per angle of the whole string in static twist, G J / L [N m/rad]."""
        return self.G * self.J / self.L

    def cells_for(self, requested: int) -> int:
        """Return the cells in one travel time: as requested, at least 4; for 0 so many that none exceeds CELL_LIMIT."""
        if requested > 0:
            return requested if requested >= 4 else 4
        count = int(self.travel_time / CELL_LIMIT)
        if count * CELL_LIMIT < self.travel_time:
            count += 1
        return count if count >= 4 else 4


@dataclass(frozen=True)
class DistributedParameters(DrillstringParameters):
    """Parameters of the string with damping along it.

    Attributes
    ----------
    beta : float
        Damping per unit length [N s/rad], at least 0; the paper gives no value.
    """

    beta: float = 0.0

    def __post_init__(self) -> None:
        """Refuse what is not physical: ValueError with name, value and expected range."""
        super().__post_init__()
        if not isfinite(self.beta) or self.beta < 0.0:
            raise ValueError(f"parameter beta is {self.beta}; expected a finite value >= 0")

    @property
    def exchange_rate(self) -> float:
        """Rate beta / (4 I) at which waves that cross change each other, for a pair of blocks [1/s]."""
        return 0.25 * self.beta / self.I

    @property
    def damping_blocks(self) -> float:
        """Blocks in a travel time that the damping alone asks for."""
        return self.travel_time * self.exchange_rate / MOST_STRENGTH

    def blocks_for(self, cells: int, stations: int) -> int:
        """Return the blocks in a travel time: a multiple of the parts into which the stations divide the string."""
        blocks = blocks_for(cells)
        ratio = self.damping_blocks
        damped = int(ratio)
        if damped < ratio:
            damped += 1
        if damped > blocks:
            blocks = damped
        parts = stations + 1
        return (blocks + parts - 1) // parts * parts
