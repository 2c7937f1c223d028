"""What the documentation page inside each FMU says: the equations it computes, and where they end to hold.

Labels "Eq. (n)" are numbers of the paper, "model n" those of docs/model.md, as in the interface tables.
"""

from __future__ import annotations

from .prose import paragraphs, phrase

Section = tuple[str, str]
"""Heading and HTML text."""

PLANT_EQUATIONS: tuple[Section, ...] = (
    (
        "The string",
        paragraphs(r"""
The angle $\theta(\xi, t)$ of an elastic string without damping along its length obeys the wave equation. At the top,
$\xi = 0$, the drive turns with $\Omega$ (`Omega`) and slides; at the bit, $\xi = L$, an inertia is slowed by the rock.

$$ G J \frac{\partial^2 \theta}{\partial \xi^2} = I \frac{\partial^2 \theta}{\partial t^2} $$ Eq. (1)

$$ G J \frac{\partial \theta}{\partial \xi}(0, t) = c_a (\frac{\partial \theta}{\partial t}(0, t) - \Omega(t))
$$ Eq. (2)

$$ G J \frac{\partial \theta}{\partial \xi}(L, t) + I_B \frac{\partial^2 \theta}{\partial t^2}(L, t)
= -T(\frac{\partial \theta}{\partial t}(L, t)) $$ Eq. (2)
"""),
    ),
    (
        "Torque on bit",
        paragraphs(r"""
With the bit speed $v$ (`bit_speed`) and the weight on bit $W$ (`WOB`),

$$ T(v) = c_b v + W R_b \mu_b(v) \sgn \, v $$ Eq. (3)

$$ \mu_b(v) = \mu_{cb} + (\mu_{sb} - \mu_{cb}) e^{-(\gamma_b / v_f) |v|} $$ Eq. (4)

At rest the dry friction is any torque up to the static one. The bit stays stuck while the wave $D$ that arrives from
above (see below) does not overcome it,

$$ |2 Z D(t - \Gamma)| \le W R_b \mu_{sb}, $$ model 9

and `bit_torque` is then the reaction of the rock, $2 Z D(t - \Gamma)$. Stop and release are located within a step,
however long it is. Slip backwards obeys the same law.
"""),
    ),
    (
        "Waves",
        paragraphs(r"""
The motion is the sum of a wave down and a wave up the string. In terms of their speeds, with impedance, travel time and
top reflection

$$ Z = \sqrt{I G J}, \quad \Gamma = L \sqrt{\frac{I}{G J}}, \quad \Lambda = c_a + Z, \quad
\Upsilon = \frac{c_a - Z}{\Lambda}, $$ model 5

the top sends $D$ down, and the bit sends $U$ up:

$$ D(t) = -\Upsilon U(t - \Gamma) + \frac{c_a}{\Lambda} \Omega(t), \quad \dot{y}(t) = U(t - \Gamma) + D(t) $$ model 6

$$ I_B \frac{d v}{d t}(t) = 2 Z D(t - \Gamma) - Z v(t) - T(v(t)), \quad U(t) = v(t) - D(t - \Gamma) $$ model 7

where $\dot{y}$ is `top_speed`. Eliminating the waves gives the neutral delay equations, Eq. (14) and (15).
"""),
    ),
    (
        "Before the start",
        paragraphs(r"""
The string turns uniformly with $v_0$ (`initial_speed`) and transmits the uniform torque $\tau_0$ (`initial_torque`):

$$ D = \frac{v_0}{2} + \frac{\tau_0}{2 Z}, \quad U = \frac{v_0}{2} - \frac{\tau_0}{2 Z} \quad (t \le 0) $$ model 8

Rest is 0 and 0. A running equilibrium with the bit speed $w$ has $v_0 = w$, $\tau_0 = T(w)$ and
$\Omega = w + T(w) / c_a$. The choice matters: at the start values of all other variables the string sticks and slips
for ever from rest, and turns steadily from its running equilibrium, `initial_speed` = 6.205186764 rad/s and
`initial_torque` = 7589.626471 N.m.
"""),
    ),
    (
        "Energy",
        paragraphs(r"""
$$ E(t) = Z \int_{t - \Gamma}^{t} (U^2 + D^2) \, d \tau + \frac{1}{2} I_B v^2 $$ Eq. (7) times I L / 2

At any time `energy` is its initial value plus `work_in` less `bit_loss` less `folded_energy`. The drive gives more than
`work_in`: of `drive_work`, the integral of $c_a (\Omega - \dot{y}) \Omega$, the sliding top loses `top_loss`, that of
$c_a (\Omega - \dot{y})^2$.
"""),
    ),
    (
        "How it is computed",
        paragraphs(r"""
The resolution is given in cells, $N$ to a travel time. With `cells` = 0, $N$ is the least number, and at least 4, with

$$ \frac{\Gamma}{N} \le 0.5 \, \text{ms}. $$ model 14

Up to eight cells make a block, in which waves and bit speed are polynomials of degree four where the solution is
smooth, and of as many pieces as it takes where it is not. The bit equation is solved by collocation at the four Lobatto
points, of order six. A jump or a kink at any place divides its block and travels with the waves through all their
reflections; one that has become too weak to matter is folded (`breaks_folded`, `folded_energy`, model 16). Both ends
are computed ahead of the present time, so that held inputs give the same result whatever the communication points are.
"""),
    ),
)

PLANT_LIMITS: tuple[str, ...] = tuple(
    phrase(limit)
    for limit in (
        "Torsion only, of one uniform pipe without damping along its length; no axial or lateral motion.",
        "The paper gives no value of `I_B`. The start value, 89 kg.m2, is the usual one in the same authors' work.",
        "An input is held over the step, unless its derivative has been given with fmi2SetRealInputDerivatives. A "
        "derivative holds for the next step only; after it the input has again the value that was set, not the one the "
        "ramp has reached. A step in which a derivative takes `WOB` below zero is refused with fmi2Discard.",
        "After initialisation outputs are values just after the inputs take effect. After a step they are values with "
        "the inputs of that step, just before others take effect.",
        "Of several stops within one communication step `last_stop_time` tells the last, and so does "
        "`last_release_time` of releases; `slip_count`, `stuck_time`, `bit_speed_min` and `bit_speed_max` miss none.",
        "1 to 3 `cells` count as 4. More than 10 million cells chosen automatically are refused.",
    )
)

DISSIPATIVE_LAW_EQUATIONS: tuple[Section, ...] = (
    (
        "As printed",
        paragraphs(r"""
With `form` = printed, the top speed $\dot{y}$, the bit speed $v$ and the wanted bit speed $r$ (`bit_speed_ref`),

$$ \Omega = c_1 \dot{y} + 2 \sqrt{\frac{c_b}{c_a} (1 - c_1)} \, v + 2 \sqrt{c_2 (1 - c_1)} \, r
- \frac{c_2 r^2}{\dot{y}} - 2 \sqrt{\frac{c_2 c_b}{c_a}} \, \frac{v r}{\dot{y}}. $$ Eq. (9)

Where $|\dot{y}|$ is less than `top_speed_min`, the divisor is `top_speed_min` with the sign of $\dot{y}$, that of +0
being positive, and `guard_active` is true. The result is kept within

$$ -\Omega_{\text{max}} \le \Omega \le \Omega_{\text{max}}, $$ model 18

and `limit_active` says whether that has changed it. A value found with guard or limit active is not a solution of
Eq. (9).
"""),
    ),
    (
        "In deviations from the wanted rotation",
        paragraphs(r"""
With `form` = tracking, the same completion of the square, given the torque on bit $T_{\text{ref}}$ (`bit_torque_ref`)
that goes with the wanted speed:

$$ \Omega = r + \frac{T_{\text{ref}}}{c_a} + c_1 (\dot{y} - r) + 2 \sqrt{\frac{c_b}{c_a} (1 - c_1)} \, (v - r)
$$ model 19

Without its last term this is the string with $c_a (1 - c_1)$ in place of $c_a$; $c_1 = 1 - Z / c_a$ absorbs every wave
that arrives at the top. The limit of model 18 holds here as well.
"""),
    ),
)

DISSIPATIVE_LAW_LIMITS: tuple[str, ...] = tuple(
    phrase(limit)
    for limit in (
        "**The printed form cannot hold a drilling speed**, as said above.",
        "In the tracking form the energy of the deviations grows only by what the falling slope of the friction feeds "
        r"into them. A stuck bit is certain to come loose only if $c_a (1 - c_1) r + T_{\text{ref}}$ exceeds the "
        r"static friction; near $c_1 = 1 - Z / c_a$ it stays stuck.",
        "`c_a` and `c_b` must be those of the plant.",
    )
)

WEIGHT_ON_BIT_LAW_EQUATIONS: tuple[Section, ...] = (
    (
        "Weight on bit",
        paragraphs(r"""
With the bit speed $v$,

$$ W = K_w |v| + W_0, $$ Eq. (22)

$$ W \le W_{\text{max}}. $$ model 20
"""),
    ),
)

WEIGHT_ON_BIT_LAW_LIMITS: tuple[str, ...] = tuple(
    phrase(limit)
    for limit in (
        "The paper gives neither a value of `K_w` nor an upper limit; both start values are this project's own.",
        "`WOB_max` less than `WOB_0` is refused with fmi2Discard: by fmi2ExitInitializationMode, or by the next step.",
    )
)

DRILLING_PROGRAM_EQUATIONS: tuple[Section, ...] = (
    (
        "One change of each",
        paragraphs(r"""
Rotation and weight each go on a straight line from $a$ (`_initial`) to $b$ (`_final`), beginning at $t_0$ (`_start`)
and taking $d$ (`_duration`); a duration of 0 is a step.

$$ x(t) = a + (b - a) \, \min(\max(\frac{t - t_0}{d}, 0), 1) $$ model 21
"""),
    ),
    (
        "Or a table",
        paragraphs(r"""
`table` is the path of a CSV file that replaces both changes. Its first line is `time,speed,WOB`; then one row a point,
in s, rad/s and N. Values follow straight lines between rows, and jump where two rows share a time; the first row holds
before it, the last row after it.
"""),
    ),
    (
        "Outputs",
        paragraphs(r"""
`Omega`, `speed_ref` and `bit_speed_ref` are the rotation, under the names by which drives and laws know it; `WOB` is
the weight. `bit_torque_ref` is the torque on bit at that rotation $v$ and weight $W$:

$$ T(v) = c_b v + W R_b (\mu_{cb} + (\mu_{sb} - \mu_{cb}) e^{-(\gamma_b / v_f) |v|}) \sgn \, v $$ Eq. (3), (4)
"""),
    ),
)

DRILLING_PROGRAM_LIMITS: tuple[str, ...] = tuple(
    phrase(limit)
    for limit in (
        "Outputs are known at communication points: a jump between two of them is seen at the second. A change within "
        "1e-9 max(1, |t|) s of a point counts as being there, so that rounding in the importer cannot put it off by a "
        "step.",
        "The table is read during initialisation, which a file that is missing or not understood refuses with "
        "fmi2Discard. The path is that of the importer's machine, 1023 bytes at most.",
        "The friction parameters must be those of the plant.",
    )
)
