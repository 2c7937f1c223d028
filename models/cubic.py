"""Cubic polynomials on the unit interval, the form every wave and every speed is kept in.

A cubic is the tuple ``(c0, c1, c2, c3)`` of c0 + c1 x + c2 x^2 + c3 x^3, with x from 0 at the begin of its piece to 1 at
the end.
"""

from __future__ import annotations

from math import sqrt

Cubic = tuple[float, float, float, float]

ZERO: Cubic = (0.0, 0.0, 0.0, 0.0)
THIRD = 0.3333333333333333
NONE = 2.0
"""What a search in [0, 1] returns when there is nothing to find."""


def value(c: Cubic, x: float) -> float:
    """Return the value at x."""
    return c[0] + x * (c[1] + x * (c[2] + x * c[3]))


def integral(c: Cubic, x: float) -> float:
    """Return the integral from 0 to x."""
    return x * (c[0] + x * (0.5 * c[1] + x * (THIRD * c[2] + x * (0.25 * c[3]))))


def restrict(c: Cubic, x0: float, x1: float) -> Cubic:
    """Return the cubic whose [0, 1] is [x0, x1] of the given one; outside [0, 1] this extends it."""
    if x0 == 0.0 and x1 == 1.0:
        return c
    w = x1 - x0
    w2 = w * w
    d1 = c[1] + x0 * (2.0 * c[2] + x0 * (3.0 * c[3]))
    d2 = c[2] + x0 * (3.0 * c[3])
    return (value(c, x0), w * d1, w2 * d2, w2 * w * c[3])


def subtract(a: Cubic, b: Cubic) -> Cubic:
    """Return a - b."""
    return (a[0] - b[0], a[1] - b[1], a[2] - b[2], a[3] - b[3])


def product_integral(a: Cubic, b: Cubic, x: float) -> float:
    """Return the integral of a b from 0 to x, exact but for rounding."""
    s0 = a[0] * b[0]
    s1 = a[0] * b[1] + a[1] * b[0]
    s2 = a[0] * b[2] + a[1] * b[1] + a[2] * b[0]
    s3 = a[0] * b[3] + a[1] * b[2] + a[2] * b[1] + a[3] * b[0]
    s4 = a[1] * b[3] + a[2] * b[2] + a[3] * b[1]
    s5 = a[2] * b[3] + a[3] * b[2]
    s6 = a[3] * b[3]
    tail = 0.25 * s3 + x * (0.2 * s4 + x * (0.16666666666666666 * s5 + x * (0.14285714285714285 * s6)))
    return x * (s0 + x * (0.5 * s1 + x * (THIRD * s2 + x * tail)))


def hermite(v0: float, v1: float, m0: float, m1: float) -> Cubic:
    """Return the cubic with values v0, v1 and slopes m0, m1 (per unit of x) at 0 and 1."""
    rise = v1 - v0
    return (v0, m0, 3.0 * rise - 2.0 * m0 - m1, m0 + m1 - 2.0 * rise)


def stationary_points(c: Cubic) -> tuple[float, float]:
    """Return the two places where the slope is zero, ascending; NONE for each that does not lie in (0, 1)."""
    q = c[2] * c[2] - 3.0 * c[3] * c[1]
    if q <= 0.0:
        return NONE, NONE
    t = -(c[2] + sqrt(q)) if c[2] >= 0.0 else sqrt(q) - c[2]
    x0 = NONE if c[3] == 0.0 else t / (3.0 * c[3])
    x1 = c[1] / t
    if not 0.0 < x0 < 1.0:
        x0 = NONE
    if not 0.0 < x1 < 1.0:
        x1 = NONE
    return (x0, x1) if x0 <= x1 else (x1, x0)


def extremes(c: Cubic, x0: float, x1: float) -> tuple[float, float]:
    """Return the least and the greatest value on [x0, x1]."""
    left = value(c, x0)
    right = value(c, x1)
    low, high = (left, right) if left <= right else (right, left)
    for x in stationary_points(c):
        if x0 < x < x1:
            y = value(c, x)
            if y < low:
                low = y
            if y > high:
                high = y
    return low, high


def first_positive(c: Cubic) -> float:
    """Return the first x in [0, 1] from which the cubic is positive, NONE if there is none.

    At the returned place the value is positive, one representable number before it is not, unless it is 0.
    """
    if c[0] > 0.0:
        return 0.0
    b1 = c[0] + THIRD * c[1]
    b2 = b1 + THIRD * (c[1] + c[2])
    end = c[0] + c[1] + c[2] + c[3]
    if b1 <= 0.0 and b2 <= 0.0 and end <= 0.0:
        return NONE  # the control polygon, and with it the cubic, is nowhere positive
    left = 0.0
    first, second = stationary_points(c)
    for right in (first, second, 1.0):
        if right <= 1.0:
            if value(c, right) > 0.0:
                return _bisect(c, left, right)
            left = right
    return NONE


def _bisect(c: Cubic, left: float, right: float) -> float:
    """Shrink [left, right], not positive at left and positive at right, to neighbouring numbers; return the right one."""
    for _ in range(200):
        middle = 0.5 * (left + right)
        if middle <= left or middle >= right:
            break
        if value(c, middle) > 0.0:
            right = middle
        else:
            left = middle
    return right


def merge(a: Cubic, b: Cubic, u: float) -> tuple[Cubic, float]:
    """Return the cubic on [0, 1] with the first four moments of a on [0, u] and b on [u, 1], and how much a and b differ.

    The longer of the two is extended over the whole and corrected by the projection of the rest, so that a small break
    costs no digits. The difference is a bound in the units of the values: a jump counts whole, the rest as far as a
    cubic cannot follow it.
    """
    if u >= 0.5:
        base = restrict(a, 0.0, 1.0 / u)
        start, width = u, 1.0 - u
        rest = subtract(b, restrict(base, u, 1.0))
        jump = rest[0]
    else:
        base = restrict(b, -u / (1.0 - u), 1.0)
        start, width = 0.0, u
        rest = subtract(a, restrict(base, 0.0, u))
        jump = value(rest, 1.0)
    difference = abs(jump) + 0.2 * abs(rest[1]) + 0.1 * (abs(rest[2]) + abs(rest[3]))
    correction = _projection(rest, start, width)
    merged = (base[0] + correction[0], base[1] + correction[1], base[2] + correction[2], base[3] + correction[3])
    return merged, difference


def _projection(c: Cubic, start: float, width: float) -> Cubic:
    """Return the least-squares cubic on [0, 1] of a function that is c on [start, start + width] and 0 elsewhere."""
    n0 = c[0] + 0.5 * c[1] + THIRD * c[2] + 0.25 * c[3]
    n1 = 0.5 * c[0] + THIRD * c[1] + 0.25 * c[2] + 0.2 * c[3]
    n2 = THIRD * c[0] + 0.25 * c[1] + 0.2 * c[2] + 0.16666666666666666 * c[3]
    n3 = 0.25 * c[0] + 0.2 * c[1] + 0.16666666666666666 * c[2] + 0.14285714285714285 * c[3]
    s = start
    w = width
    m0 = w * n0
    m1 = w * (s * n0 + w * n1)
    m2 = w * (s * s * n0 + w * (2.0 * s * n1 + w * n2))
    m3 = w * (s * s * s * n0 + w * (3.0 * s * s * n1 + w * (3.0 * s * n2 + w * n3)))
    return (
        16.0 * m0 - 120.0 * m1 + 240.0 * m2 - 140.0 * m3,
        -120.0 * m0 + 1200.0 * m1 - 2700.0 * m2 + 1680.0 * m3,
        240.0 * m0 - 2700.0 * m1 + 6480.0 * m2 - 4200.0 * m3,
        -140.0 * m0 + 1680.0 * m1 - 4200.0 * m2 + 2800.0 * m3,
    )
