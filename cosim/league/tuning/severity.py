"""Put into one number how bad a run is, and how bad a law is over all conditions: what tuning makes least."""

from __future__ import annotations

import math
from collections.abc import Sequence

from cosim.league.score import Score

EFFORT = 0.1
"""What the drive's swing counts, against that of the bit."""
STUCK, FAILED = 2.0, 4.0


def severity(score: Score, judge: float) -> float:
    """Return how bad a run is.

    A run that ends free of stick-slip: the time to free as a part of the time judged, and the SSI of the bit, and a
    tenth of that of the drive, drive_swing / (2 mean_top_speed); at most 2. One that ends stuck: 2 and the stuck
    fraction. One that fails: 4.

    Parameters
    ----------
    score : Score
        What the run was.
    judge : float
        How long it was judged [s].
    """
    if score.failure:
        return FAILED
    if not score.free:
        return STUCK + score.stuck_fraction
    effort = score.drive_swing / (2.0 * score.mean_top_speed) if score.mean_top_speed > 0.0 else math.inf
    return min(STUCK, score.time_to_free / judge + score.ssi + EFFORT * effort)


def overall(scores: Sequence[Score], judge: float) -> float:
    """Return how bad a law is: halfway between the worst of its runs and their mean."""
    each = [severity(score, judge) for score in scores]
    return 0.5 * (max(each) + math.fsum(each) / len(each))
