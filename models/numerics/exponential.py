"""An exponential made of + - * only, so that it has the same bits on every platform.

libm and numpy differ from each other in the last bit and between versions; a stick-slip trajectory would show it.
"""

from __future__ import annotations

from math import ldexp

LOG2_E = 1.4426950408889634
LN2_HIGH = 0.6931471803691238
"""Upper 32 bits of ln 2: its products with the exponents that occur are exact."""
LN2_LOW = 1.9082149292705877e-10

LEAST, GREATEST = -708.0, 709.0
"""Outside, the result is 0 or that of the bound: it stays a normal number."""

_POWERS_OF_TWO = tuple(ldexp(1.0, k) for k in range(-1022, 1024))


def exponential(x: float) -> float:
    """Return e^x to less than one unit in the last place, for x in [-708, 709].

    ``x = k ln 2 + r`` with ``|r| <= ln 2 / 2``, then the Taylor polynomial of degree 13 in Estrin's order, then an
    exact scaling by 2^k.

    Parameters
    ----------
    x : float
        Any finite number; below -708 the result is 0, above 709 it is that of 709.
    """
    if x < LEAST:
        return 0.0
    if x > GREATEST:
        x = GREATEST
    k = int(x * LOG2_E + 1024.5) - 1024
    high = x - k * LN2_HIGH
    low = k * LN2_LOW
    r = high - low
    s = r * r
    q = s * s
    p01 = 0.5 + r * 0.16666666666666666
    p23 = 0.041666666666666664 + r * 0.008333333333333333
    p45 = 0.001388888888888889 + r * 0.0001984126984126984
    p67 = 2.48015873015873e-05 + r * 2.7557319223985893e-06
    p89 = 2.755731922398589e-07 + r * 2.505210838544172e-08
    pab = 2.08767569878681e-09 + r * 1.6059043836821613e-10
    p = (p01 + s * p23) + q * ((p45 + s * p67) + q * (p89 + s * pab))
    return (1.0 + (high + (s * p - low))) * _POWERS_OF_TWO[k + 1022]
