"""Sine and cosine made of + - * only, so that they have the same bits on every platform."""

from __future__ import annotations

from typing import NamedTuple

QUARTERS = 0.6366197723675814
"""Quarter turns in a radian, 2 / pi."""
QUARTER_HIGH = 1.5707963267341256
"""Upper 33 bits of pi / 2: its products with the counts that occur are exact."""
QUARTER_LOW = 6.077100506506192e-11


class SineCosine(NamedTuple):
    """Sine and cosine of one angle."""

    sine: float
    cosine: float


def sine_and_cosine(angle: float) -> SineCosine:
    """Return sine and cosine of an angle [rad] between -1e5 and 1e5, to about one unit in the last place of 1.

    The angle is that of a number of quarter turns and a rest of at most pi / 4, for which the Taylor polynomials of
    degree 17 and 16 are summed from the last term on.
    """
    quarters = int(angle * QUARTERS + 65536.5) - 65536
    x = (angle - quarters * QUARTER_HIGH) - quarters * QUARTER_LOW
    s = x * x
    sine = 2.8114572543455206e-15
    sine = sine * s - 7.647163731819816e-13
    sine = sine * s + 1.6059043836821613e-10
    sine = sine * s - 2.505210838544172e-08
    sine = sine * s + 2.7557319223985893e-06
    sine = sine * s - 0.0001984126984126984
    sine = sine * s + 0.008333333333333333
    sine = sine * s - 0.16666666666666666
    sine = x + x * (sine * s)
    cosine = 4.779477332387385e-14
    cosine = cosine * s - 1.1470745597729725e-11
    cosine = cosine * s + 2.08767569878681e-09
    cosine = cosine * s - 2.755731922398589e-07
    cosine = cosine * s + 2.48015873015873e-05
    cosine = cosine * s - 0.001388888888888889
    cosine = cosine * s + 0.041666666666666664
    cosine = cosine * s - 0.5
    cosine = 1.0 + cosine * s
    match quarters % 4:
        case 0:
            return SineCosine(sine, cosine)
        case 1:
            return SineCosine(cosine, -sine)
        case 2:
            return SineCosine(-sine, -cosine)
        case _:
            return SineCosine(-cosine, sine)
