"""Write the documentation page of DrillstringNeutral.

Labels "Eq. (n)" are numbers of the paper, "model n" those of docs/model.md, as in the interface table.
"""

from __future__ import annotations

from ...page.prose import Sections, paragraphs, phrases

EQUATIONS: Sections = (
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

LIMITS = phrases(
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
    "Values that ask for more than 40 times the work of the start values all the time are refused before the start: "
    "a very light or viscous bit, very many `cells`, a very short string. A step in which the bit is thrown about so "
    "fast that following it takes more than 50 times is refused with fmi2Discard; the instance is as it was before, "
    "and takes a shorter step, or one with other inputs.",
)

_LOOP = (
    "The string answers at once: `top_speed` and `top_torque` answer `Omega`, and `bit_torque` answers `WOB`. A law "
    "that computes one from the other closes an algebraic loop. Co-simulation masters open it by one communication "
    "step, so the step is the law's sample time: take 0.001 s. A tool that refuses the loop wants a unit delay in the "
    "connection of `Omega`."
)

USE = phrases(
    "Run it alone, with nothing connected and nothing set, from 0 to 100 s in steps of 0.01 s: this is the "
    "stick-slip cycle of the paper's Fig. 2. The bit first breaks loose at 2.603019251 s (`last_release_time`) and "
    "first stops at 4.226441632 s (`last_stop_time`). At the end the period is 3.2256227 s, the greatest "
    "`bit_speed_max` 18.7605 rad/s. If these come out, the import is right.",
    "Drive `Omega` and `WOB`, or connect the FMU DrillingProgram. Everywhere equal names fit.",
    "As long as inputs are held, the result does not depend on the communication step: 0.01 s is a good one, any "
    "other will do, constant or not. For what happens within a long step there are `bit_speed_min`, "
    "`bit_speed_max`, `slip_count`, `stuck_time`, `last_stop_time` and `last_release_time`.",
    _LOOP,
    "To begin in steady drilling, set `initial_speed`, `initial_torque` and `Omega` as told under “Before the start”.",
    "The paper's law for the drive speed is the FMU DissipativeLaw. As printed, (9) cannot hold a drilling speed; "
    "its tracking form can. The page of that FMU says why.",
)
