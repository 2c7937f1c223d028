"""The cases to time: each peer at the resolution it needs, and on record the runs too slow to repeat in a benchmark."""

from collections.abc import Callable
from dataclasses import dataclass

from . import heun_ring, jitcdde_peer, method_of_lines
from .cycle import Slips

END_TIME = 100.0  # s, from rest


@dataclass(frozen=True)
class Case:
    """A peer at the coarsest resolution whose period is within an error.

    Attributes
    ----------
    peer : str
        Name of the peer.
    error : float, s
        Period error it stays within, at this resolution and at every finer one tried.
    simulate : callable
        ``simulate(resolution, end_time)`` runs from rest and returns ``Slips``.
    resolution : float
        In the peer's own measure.
    rounds : int
        Timed runs worth doing.
    """

    peer: str
    error: float
    simulate: Callable[[float, float], Slips]
    resolution: float
    rounds: int

    def prepare(self) -> None:
        """Compile what the peer compiles, so that no later run does; costs little once done."""
        self.simulate(PREPARING[self.simulate], 10.0)

    def run(self) -> Slips:
        """Simulate 100 s of Fig. 2; the first run of a peer in a process compiles it, unless prepared."""
        return self.simulate(self.resolution, END_TIME)


@dataclass(frozen=True)
class Recorded:
    """One run of 100 s of Fig. 2, measured once on one 2020s x86-64 core, without compilation.

    Attributes
    ----------
    peer : str
        Name of the peer.
    resolution : float
        In the peer's own measure.
    error : float, s
        Absolute error of the period.
    seconds : float, s
        Processor time, equal to the wall time of an idle core.
    """

    peer: str
    resolution: float
    error: float
    seconds: float


CLAMPED = "numba Heun, clamped"
LOCATED = "numba Heun, located"
JITCDDE = "jitcdde"
LINES = "SciPy method of lines"

PREPARING = {  # resolutions that cost little
    heun_ring.simulate_interpolated: 10,
    heun_ring.simulate_located: 10,
    jitcdde_peer.simulate: 1e-3,
    method_of_lines.simulate: 10,
}

PEERS = (
    Case(CLAMPED, 1e-4, heun_ring.simulate_interpolated, 310, rounds=20),  # steps in a travel time
    Case(LOCATED, 1e-4, heun_ring.simulate_located, 240, rounds=20),
    Case(JITCDDE, 1e-4, jitcdde_peer.simulate, 5.6e-4, rounds=5),  # rad/s, absolute tolerance
    Case(LINES, 1e-4, method_of_lines.simulate, 900, rounds=1),  # cells
    Case(CLAMPED, 1e-6, heun_ring.simulate_interpolated, 3200, rounds=20),
    Case(LOCATED, 1e-6, heun_ring.simulate_located, 2470, rounds=20),
    Case(JITCDDE, 1e-6, jitcdde_peer.simulate, 4.2e-7, rounds=5),
)

# The method of lines takes minutes to 1e-6 s, so it is not timed there. Its error changes sign close to 4800 cells,
# which flatters it around there.
RECORDED = (
    Recorded(LINES, 3200, 2.7e-6, 78.0),
    Recorded(LINES, 4000, 8.3e-7, 124.0),  # the coarsest within 1e-6 s
    Recorded(LINES, 4800, 4.9e-9, 158.0),
    Recorded(LINES, 6400, 4.8e-7, 325.0),  # seconds from the first 8 s simulated
)
