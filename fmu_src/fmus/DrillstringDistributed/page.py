"""Write the documentation page of DrillstringDistributed.

Labels "Eq. (n)" are numbers of the paper, "model n" those of docs/model.md, as in the interface table.
"""

from __future__ import annotations

from ...page.prose import Sections, paragraphs, phrase
from ..DrillstringNeutral import page as neutral

EQUATIONS: Sections = (
    (
        "The string",
        paragraphs(r"""
The angle $\theta(\xi, t)$ of an elastic string with the damping $\beta$ (`beta`) along its length obeys the damped wave
equation. At the top, $\xi = 0$, the drive turns with $\Omega$ (`Omega`) and slides; at the bit, $\xi = L$, an inertia
is slowed by the rock.

$$ G J \frac{\partial^2 \theta}{\partial \xi^2} - I \frac{\partial^2 \theta}{\partial t^2}
- \beta \frac{\partial \theta}{\partial t} = 0 $$ Eq. (1)

$$ G J \frac{\partial \theta}{\partial \xi}(0, t) = c_a (\frac{\partial \theta}{\partial t}(0, t) - \Omega(t))
$$ Eq. (2)

$$ G J \frac{\partial \theta}{\partial \xi}(L, t) + I_B \frac{\partial^2 \theta}{\partial t^2}(L, t)
= -T(\frac{\partial \theta}{\partial t}(L, t)) $$ Eq. (2)
"""),
    ),
    neutral.EQUATIONS[1],
    (
        "Waves",
        paragraphs(r"""
With the impedance $Z = \sqrt{I G J}$ and the travel time $\Gamma = L \sqrt{I / (G J)}$, the speed of the string is the
sum of a wave up and a wave down the string, and its torque is $Z (D - U)$. Along the way of each

$$ \frac{d U}{d t} = \frac{d D}{d t} = -\frac{\beta}{2 I} (U + D). $$ model 24

At the ends the waves are what they are without damping:

$$ (c_a + Z) D = -(c_a - Z) U + c_a \Omega, \quad \dot{y} = U + D \quad (\xi = 0) $$ model 6

$$ I_B \frac{d v}{d t} = 2 Z D - Z v - T(v), \quad U = v - D \quad (\xi = L) $$ model 7

Without damping this is the FMU DrillstringNeutral.
"""),
    ),
    (
        "Before the start",
        paragraphs(r"""
The string turns uniformly with $v_0$ (`initial_speed`) and transmits to the bit the torque $\tau_0$ (`initial_torque`);
what turns it against its own damping comes on top:

$$ \tau(\xi) = \tau_0 + \beta v_0 (L - \xi) $$ model 26

Rest is 0 and 0. A running equilibrium with the bit speed $w$ has $v_0 = w$, $\tau_0 = T(w)$ and
$\Omega = w + (T(w) + \beta L w) / c_a$.
"""),
    ),
    (
        "Stations",
        paragraphs(r"""
`stations` places divide the string into equal parts. Counted from the top, station $n$ of $N$ is at

$$ \xi = \frac{n}{N + 1} L. $$ model 27

Its outputs are the speed $\partial \theta / \partial t$, the torque $-G J \, \partial \theta / \partial \xi$, and the
twist of the string above it, $\theta(0, t) - \theta(\xi, t)$. At the ends there are `top_speed`, `top_torque`,
`bit_speed` and `bit_torque`; the twist of the whole string is `top_angle` less `bit_angle`.
"""),
    ),
    (
        "Energy",
        paragraphs(r"""
$$ E(t) = \frac{1}{2} \int_0^L (I (\frac{\partial \theta}{\partial t})^2
+ G J (\frac{\partial \theta}{\partial \xi})^2) \, d \xi + \frac{1}{2} I_B v^2 $$ Eq. (7) times I L / 2

The drive puts in `drive_work`, the integral of $c_a (\Omega - \dot{y}) \Omega$. Of it `top_loss` is lost in the
sliding top; the rest is `work_in`. `bit_loss` is lost at the bit, and `string_loss`, the integral of
$\beta (\partial \theta / \partial t)^2$ over the string, along it. Each is accumulated on its own: that `energy` is its
initial value plus `work_in` less `bit_loss`, `string_loss` and `folded_energy` is a check. It holds to rounding where
`beta` is zero, and otherwise as closely as the cells are fine.
"""),
    ),
    (
        "How it is computed",
        paragraphs(r"""
As in DrillstringNeutral: waves are kept as polynomials of degree four in blocks of up to eight cells,

$$ \frac{\Gamma}{N} \le 0.5 \, \text{ms}, $$ model 14

divided where the solution has jumps or kinks, and the bit equation is solved by collocation. Where a block of one wave
crosses a block of the other, damping changes both,

$$ U' - U = -\kappa (\frac{U + U'}{2} + D_m), \quad \kappa = \frac{\beta h}{4 I}, $$ model 25

with $h$ the duration of a block and $D_m$ the mean of the other wave, which changes linearly meanwhile. This is exact
in uniform rotation, creates no jumps, and is of second order otherwise. The number of blocks is a multiple of
$N + 1$, so that stations lie where blocks meet; strong damping makes blocks shorter.
"""),
    ),
)

USE: tuple[str, ...] = (
    phrase(
        "It takes the place of DrillstringNeutral anywhere: same inputs, same outputs and more. Nothing set, `beta` is "
        "zero as in the paper's simulations, and the results are the same."
    ),
    phrase(
        "Set `beta` [N.s/rad per metre of string] for damping along the string: the paper gives no value. 0.05 takes "
        "about a tenth off a wave on its way along the string of the start values, and costs 586 N.m at 10 rad/s."
    ),
    *neutral.USE,
)

LIMITS: tuple[str, ...] = (
    phrase("Torsion only, of one uniform pipe, whose damping is the same everywhere; no axial or lateral motion."),
    phrase(
        "With damping the error falls with the second power of the cell. At `beta` = 0.1 and the default cells it is "
        "about 1e-5 rad/s after a jump of `Omega` by 10 rad/s, and less where the solution is smoother."
    ),
    *neutral.LIMITS[1:],
)
