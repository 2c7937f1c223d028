"""Write the documentation page of TopDrive.

Labels "cures n" are numbers of docs/cures.md, as in the interface table.
"""

from __future__ import annotations

from ...page.prose import Sections, paragraphs, phrases

EQUATIONS: Sections = (
    (
        "A speed behind a lag",
        paragraphs(r"""
With `mode` speed, the drive follows the command $\Omega_c$ of the last sample with the time constant $T$ (`lag`),

$$ \frac{d\Omega}{dt} = \min(\max(\frac{\Omega_c - \Omega}{T}, -a), a), $$ cures 9

$a$ being `rate_limit`; it is solved exactly between samples.
"""),
    ),
    (
        "A rotor",
        paragraphs(r"""
With `mode` servo or torque, motor and string turn a rotor,

$$ J_r \frac{d\Omega}{dt} = T_m - \tau. $$ cures 10

In mode torque $T_m$ is `motor_torque`, which a law such as SpeedPid computes. In mode servo the drive has a speed
controller of its own: with the error $e$ of the speed shown against a set point that changes by `rate_limit` at most,

$$ T_m = K_p e + \int K_i e \, dt, $$ cures 11

summed at samples. While the torque is at a limit, what would drive it further is not added up.
"""),
    ),
    (
        "Limits",
        paragraphs(r"""
The motor gives

$$ T_{\text{min}} \le T_m \le \min(T_{\text{max}}, \frac{N}{|\Omega|}), $$ cures 12

with the power $N$ (`power_max`). In mode speed it gives the torque $\tau$ that the string takes, and the rotor is left
out as long as it can. A string that takes more slows the rotor down by (cures 10), and the drive sets out anew from the
speed that it has then; one that would have to be braked turns the rotor faster, which at its least torque falls back to
the speed that is asked for. `limit_active` tells of both.
"""),
    ),
    (
        "Samples, delay, noise",
        paragraphs(r"""
Commands and sensors are sampled at $k T_s$ (`sample_time`), the first time a sample after the start; a command acts
`delay` later. Sensors show

$$ x_k = x(k T_s) + \sigma n_k, $$ cures 13

where $n_k$ is the sum of twelve numbers between 0 and 1, less 6, of the generator that
takes $s$ to $48271 s$ modulo $2^{31} - 1$ and begins at `seed`. The same seed gives the same noise on every platform.
"""),
    ),
)

LIMITS = phrases(
    "`torque_min` is 0: such a drive does not brake, and turns one way. Set it to the negative of `torque_max` for one "
    "that does both.",
    "A step must not hold more than a million samples, and `delay` not more than 64.",
)

USE = phrases(
    "Put it between a law and the string: `Omega` of the law to `Omega_command`, `Omega` to the string, `top_torque` "
    "and `top_speed` from the string; and what the sensors show to the law, in place of the string's own.",
    "No law is judged with an ideal drive alone.",
    "Communication steps of a sample time have the commands of the step before; shorter steps change nothing but cost.",
)
