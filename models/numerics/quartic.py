"""Quartic polynomials on the unit interval, the form every wave and every speed is kept in.

A quartic is the tuple ``(c0, c1, c2, c3, c4)`` of c0 + c1 x + ... + c4 x^4, with x from 0 at the begin of its piece
to 1 at the end.
"""

from __future__ import annotations

from math import sqrt

Quartic = tuple[float, float, float, float, float]

ZERO: Quartic = (0.0, 0.0, 0.0, 0.0, 0.0)
NONE = 2.0
"""Result of a search in [0, 1] that finds nothing."""

THIRD = 0.3333333333333333
SIXTH = 0.16666666666666666
SEVENTH = 0.14285714285714285
NINTH = 0.1111111111111111


def value(c: Quartic, x: float) -> float:
    """Return the value at x."""
    return c[0] + x * (c[1] + x * (c[2] + x * (c[3] + x * c[4])))


def end_value(c: Quartic) -> float:
    """Return the value at 1."""
    return c[0] + c[1] + c[2] + c[3] + c[4]


def integral(c: Quartic, x: float) -> float:
    """Return the integral from 0 to x."""
    return x * (c[0] + x * (0.5 * c[1] + x * (THIRD * c[2] + x * (0.25 * c[3] + x * (0.2 * c[4])))))


def restrict(c: Quartic, x0: float, x1: float) -> Quartic:
    """Return the quartic whose [0, 1] is [x0, x1] of the given one; outside [0, 1] this extends it."""
    if x0 == 0.0 and x1 == 1.0:
        return c
    w = x1 - x0
    w2 = w * w
    d1 = c[1] + x0 * (2.0 * c[2] + x0 * (3.0 * c[3] + x0 * (4.0 * c[4])))
    d2 = c[2] + x0 * (3.0 * c[3] + x0 * (6.0 * c[4]))
    d3 = c[3] + x0 * (4.0 * c[4])
    return (value(c, x0), w * d1, w2 * d2, w2 * w * d3, w2 * w2 * c[4])


def add(a: Quartic, b: Quartic) -> Quartic:
    """Return a + b."""
    return (a[0] + b[0], a[1] + b[1], a[2] + b[2], a[3] + b[3], a[4] + b[4])


def subtract(a: Quartic, b: Quartic) -> Quartic:
    """Return a - b."""
    return (a[0] - b[0], a[1] - b[1], a[2] - b[2], a[3] - b[3], a[4] - b[4])


def product_integral(a: Quartic, b: Quartic, x: float) -> float:
    """Return the integral of a b from 0 to x, exact but for rounding."""
    s0 = a[0] * b[0]
    s1 = a[0] * b[1] + a[1] * b[0]
    s2 = a[0] * b[2] + a[1] * b[1] + a[2] * b[0]
    s3 = a[0] * b[3] + a[1] * b[2] + a[2] * b[1] + a[3] * b[0]
    s4 = a[0] * b[4] + a[1] * b[3] + a[2] * b[2] + a[3] * b[1] + a[4] * b[0]
    s5 = a[1] * b[4] + a[2] * b[3] + a[3] * b[2] + a[4] * b[1]
    s6 = a[2] * b[4] + a[3] * b[3] + a[4] * b[2]
    s7 = a[3] * b[4] + a[4] * b[3]
    s8 = a[4] * b[4]
    tail = 0.2 * s4 + x * (SIXTH * s5 + x * (SEVENTH * s6 + x * (0.125 * s7 + x * (NINTH * s8))))
    return x * (s0 + x * (0.5 * s1 + x * (THIRD * s2 + x * (0.25 * s3 + x * tail))))


def square_integral(c: Quartic) -> float:
    """Return the integral of the square from 0 to 1, exact but for rounding."""
    c0, c1, c2, c3, c4 = c
    even = c0 * c0 + THIRD * (c1 * c1 + 2.0 * (c0 * c2)) + 0.2 * (c2 * c2 + 2.0 * (c0 * c4 + c1 * c3))
    even = even + SEVENTH * (c3 * c3 + 2.0 * (c2 * c4)) + NINTH * (c4 * c4)
    odd = c0 * c1 + 0.5 * (c0 * c3 + c1 * c2) + THIRD * (c1 * c4 + c2 * c3) + 0.25 * (c3 * c4)
    return even + odd


def _slope(c: Quartic, x: float) -> float:
    return c[1] + x * (2.0 * c[2] + x * (3.0 * c[3] + x * (4.0 * c[4])))


def _inflections(c: Quartic) -> tuple[float, float]:
    """Return the places where the second derivative is zero, ascending; NONE for each that does not lie in (0, 1)."""
    q = 9.0 * (c[3] * c[3]) - 24.0 * (c[4] * c[2])
    if q <= 0.0:
        return NONE, NONE
    root = sqrt(q)
    t = -(3.0 * c[3] + root) if c[3] >= 0.0 else root - 3.0 * c[3]
    x0 = NONE if c[4] == 0.0 else t / (12.0 * c[4])
    x1 = 2.0 * c[2] / t
    if not 0.0 < x0 < 1.0:
        x0 = NONE
    if not 0.0 < x1 < 1.0:
        x1 = NONE
    return (x0, x1) if x0 <= x1 else (x1, x0)


def stationary_points(c: Quartic) -> tuple[float, float, float]:
    """Return the places where the slope changes its sign, ascending; NONE for each that is missing in (0, 1)."""
    b1 = c[1] + 2.0 * THIRD * c[2]
    b2 = c[1] + 4.0 * THIRD * c[2] + c[3]
    end = _slope(c, 1.0)
    if (c[1] >= 0.0 and b1 >= 0.0 and b2 >= 0.0 and end >= 0.0) or (
        c[1] <= 0.0 and b1 <= 0.0 and b2 <= 0.0 and end <= 0.0
    ):
        return NONE, NONE, NONE  # the control polygon of the slope, and with it the slope, keeps its sign
    found = [NONE, NONE, NONE]
    count = 0
    left = 0.0
    sign = 1.0 if c[1] > 0.0 else -1.0
    first, second = _inflections(c)
    for right in (first, second, 1.0):
        if right <= 1.0:
            if sign * _slope(c, right) < 0.0:
                found[count] = _turn(c, left, right, sign)
                count += 1
                sign = -sign
            left = right
    return found[0], found[1], found[2]


def _turn(c: Quartic, left: float, right: float, sign: float) -> float:
    """Shrink [left, right], between which the slope changes its sign once, to neighbouring numbers."""
    for _ in range(200):
        middle = 0.5 * (left + right)
        if middle <= left or middle >= right:
            break
        if sign * _slope(c, middle) > 0.0:
            left = middle
        else:
            right = middle
    return right


def extremes(c: Quartic, x0: float, x1: float) -> tuple[float, float]:
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


def first_positive(c: Quartic) -> float:
    """Return the first x in [0, 1] from which the quartic is positive, NONE if there is none.

    At the returned place the value is positive; one representable number before, it is not.
    """
    if c[0] > 0.0:
        return 0.0
    b1 = c[0] + 0.25 * c[1]
    b2 = c[0] + 0.5 * c[1] + SIXTH * c[2]
    b3 = c[0] + 0.75 * c[1] + 0.5 * c[2] + 0.25 * c[3]
    if b1 <= 0.0 and b2 <= 0.0 and b3 <= 0.0 and end_value(c) <= 0.0:
        return NONE  # the control polygon, and with it the quartic, is nowhere positive
    left = 0.0
    first, second, third = stationary_points(c)
    for right in (first, second, third, 1.0):
        if right <= 1.0:
            if value(c, right) > 0.0:
                return _rise(c, left, right)
            left = right
    return NONE


def _rise(c: Quartic, left: float, right: float) -> float:
    """Shrink [left, right], positive at right only, to neighbouring numbers; return the right one."""
    for _ in range(200):
        middle = 0.5 * (left + right)
        if middle <= left or middle >= right:
            break
        if value(c, middle) > 0.0:
            right = middle
        else:
            left = middle
    return right


def merge(a: Quartic, b: Quartic, u: float, limit: float) -> tuple[Quartic, float]:
    """Return the quartic with the first four moments of a on [0, u] and b on [u, 1], and how much they differ.

    The longer of the two is extended over the whole and corrected by the projection of the rest, so that a small break
    costs no digits. The difference is in the units of the values: a jump counts whole, the rest as far as a quartic
    cannot follow it. Where it exceeds the limit the merged quartic is not worked out.
    """
    jump = abs(b[0] - end_value(a))
    if jump > limit:
        return a, jump
    if u >= 0.5:
        base = restrict(a, 0.0, 1.0 / u)
        start, width = u, 1.0 - u
        rest = subtract(b, restrict(base, u, 1.0))
    else:
        base = restrict(b, -u / (1.0 - u), 1.0)
        start, width = 0.0, u
        rest = subtract(a, restrict(base, 0.0, u))
    difference = jump + 0.2 * abs(rest[1]) + 0.1 * (abs(rest[2]) + abs(rest[3]) + abs(rest[4]))
    if difference > limit:
        return base, difference
    return add(base, _projection(rest, start, width)), difference


def flatten(c: Quartic) -> Quartic:
    """Return the least-squares cubic on [0, 1]: the quartic less its share of the fourth Legendre polynomial."""
    c4 = c[4]
    return (
        c[0] - 0.014285714285714285 * c4,
        c[1] + 0.2857142857142857 * c4,
        c[2] - 1.2857142857142858 * c4,
        c[3] + 2.0 * c4,
        0.0,
    )


def _projection(c: Quartic, s: float, w: float) -> Quartic:
    """Return the least-squares cubic on [0, 1] of a function that is c on [s, s + w] and 0 elsewhere."""
    n0 = c[0] + 0.5 * c[1] + THIRD * c[2] + 0.25 * c[3] + 0.2 * c[4]
    n1 = 0.5 * c[0] + THIRD * c[1] + 0.25 * c[2] + 0.2 * c[3] + SIXTH * c[4]
    n2 = THIRD * c[0] + 0.25 * c[1] + 0.2 * c[2] + SIXTH * c[3] + SEVENTH * c[4]
    n3 = 0.25 * c[0] + 0.2 * c[1] + SIXTH * c[2] + SEVENTH * c[3] + 0.125 * c[4]
    s2 = s * s
    m0 = w * n0
    m1 = w * (s * n0 + w * n1)
    m2 = w * (s2 * n0 + w * (2.0 * s * n1 + w * n2))
    m3 = w * (s2 * s * n0 + w * (3.0 * s2 * n1 + w * (3.0 * s * n2 + w * n3)))
    return (
        16.0 * m0 - 120.0 * m1 + 240.0 * m2 - 140.0 * m3,
        -120.0 * m0 + 1200.0 * m1 - 2700.0 * m2 + 1680.0 * m3,
        240.0 * m0 - 2700.0 * m1 + 6480.0 * m2 - 4200.0 * m3,
        -140.0 * m0 + 1680.0 * m1 - 4200.0 * m2 + 2800.0 * m3,
        0.0,
    )
