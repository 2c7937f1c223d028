"""Collocation at the four Lobatto points of [0, 1], of order six (Lobatto IIIA; Hairer and Wanner, IV.5).

The speed over a piece is the quartic whose slope takes given values at the four points. The method is A-stable, so
that a light bit on a stiff string needs no shorter pieces.
"""

from __future__ import annotations

from .quartic import Quartic

NODES = (0.0, 0.276393202250021, 0.7236067977499789, 1.0)
WEIGHTS = (0.08333333333333333, 0.4166666666666667, 0.4166666666666667, 0.08333333333333333)

Slopes = tuple[float, float, float, float]
"""Slopes at the four points, per unit of x."""

Inner = tuple[float, float, float]
"""Something at the three points after the first."""


def antiderivative(start: float, g: Slopes) -> Quartic:
    """Return the quartic with a value at 0 and slopes at the four points."""
    return (
        start,
        g[0],
        -3.0 * g[0] + 4.045084971874737 * g[1] - 1.545084971874737 * g[2] + 0.5 * g[3],
        3.3333333333333335 * g[0] - 6.4235032770828075 * g[1] + 4.756836610416141 * g[2] - 1.6666666666666667 * g[3],
        -1.25 * g[0] + 2.7950849718747373 * g[1] - 2.7950849718747373 * g[2] + 1.25 * g[3],
    )


def values(start: float, g: Slopes) -> Inner:
    """Return the values of the antiderivative at the three points after the first."""
    return (
        start
        + (0.11030056647916492 * g[0] + 0.1896994335208351 * g[1])
        + (-0.03390736422914389 * g[2] + 0.010300566479164915 * g[3]),
        start
        + (0.07303276685416842 * g[0] + 0.45057403089581055 * g[1])
        + (0.2269672331458316 * g[2] - 0.02696723314583158 * g[3]),
        start
        + (0.08333333333333333 * g[0] + 0.4166666666666667 * g[1])
        + (0.4166666666666667 * g[2] + 0.08333333333333333 * g[3]),
    )


def correction(residual: Inner, jacobian: Inner) -> Inner:
    """Return Newton's correction of the three values: the solution of (1 - A diag(jacobian)) d = residual.

    Parameters
    ----------
    residual : Inner
        Values of the antiderivative less the values it was computed from.
    jacobian : Inner
        Derivative of each slope by its value.
    """
    p, q, r = jacobian
    a11, a12, a13 = 1.0 - 0.1896994335208351 * p, 0.03390736422914389 * q, -0.010300566479164915 * r
    a21, a22, a23 = -0.45057403089581055 * p, 1.0 - 0.2269672331458316 * q, 0.02696723314583158 * r
    a31, a32, a33 = -0.4166666666666667 * p, -0.4166666666666667 * q, 1.0 - 0.08333333333333333 * r
    f2 = a21 / a11
    f3 = a31 / a11
    b22 = a22 - f2 * a12
    b23 = a23 - f2 * a13
    b32 = a32 - f3 * a12
    b33 = a33 - f3 * a13
    s2 = residual[1] - f2 * residual[0]
    s3 = residual[2] - f3 * residual[0]
    f = b32 / b22
    d3 = (s3 - f * s2) / (b33 - f * b23)
    d2 = (s2 - b23 * d3) / b22
    return ((residual[0] - a12 * d2 - a13 * d3) / a11, d2, d3)
