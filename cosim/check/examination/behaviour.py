"""List the checks of a running FMU in order: the name and deed of each, and which must have passed before."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from cosim.check.examination import bench as messages
from cosim.check.examination import calls, derivatives, states
from cosim.check.examination import calls as refusals
from cosim.check.examination import calls as times
from cosim.check.examination import derivatives as output_derivatives
from cosim.check.examination import states as instances
from cosim.check.examination.bench import Bench
from cosim.check.verdict import Outcome


@dataclass(frozen=True)
class Check:
    """One check of a running FMU.

    Attributes
    ----------
    name, done : str
        As the table says it.
    function : callable
        Raises `cosim.check.examination.instance.CallError` where a call that must succeed does not.
    needs : tuple of str
        Checks without which this one means nothing.
    alone : bool
        Whether it must begin in a process of its own.
    spoiled_by : tuple of str
        Checks whose failure would only be found again; that they were not made does not matter.
    """

    name: str
    done: str
    function: Callable[[Bench], Outcome]
    needs: tuple[str, ...] = ("run",)
    alone: bool = False
    spoiled_by: tuple[str, ...] = ()


BEHAVIOUR = (
    Check("library", "load, ask its version", calls.check_library, ()),
    Check("instantiation", "right and wrong GUID", calls.check_instantiate, ("library",)),
    Check("start values", "get in initialization mode", calls.check_start_values, ("instantiation",)),
    Check("value references", "get each by itself", calls.check_readable, ("instantiation",)),
    Check("run", "default experiment", calls.check_run, ("instantiation",)),
    Check("repetition", "run a second instance", instances.check_repeats),
    Check("several instances", "run three in turn, free one", instances.check_together),
    Check("threads", "run two at once in threads", instances.check_threads),
    Check("reset", "run, fmi2Reset, run", instances.check_reset),
    Check("ending", "free, terminate, reset", calls.check_ends),
    Check("start time", "start 12.5 s later", times.check_start_time),
    Check("added-up time", "t += h instead of t = k h", times.check_added_times),
    Check("step sizes", "steps of 0.5, 2, 0.5, 2, 1", times.check_step_sizes),
    Check("saved states", "save, go on, go back", states.check_state),
    Check("serialised states", "go on on another instance", states.check_serialised),
    Check("other process", "go on in a new process", states.check_elsewhere, ("serialised states",), True),
    Check("damaged states", "flip and cut bytes", states.check_damaged, ("serialised states",)),
    Check("input derivatives", "ramp by slopes and by steps", derivatives.check_input_derivatives),
    Check(
        "output derivatives",
        "compare with differences",
        output_derivatives.check_output_derivatives,
        spoiled_by=("saved states", "step sizes"),
    ),
    Check("directional derivatives", "compare with differences", derivatives.check_directional_derivatives),
    Check("debug logging", "all categories, and off", messages.check_logging),
    Check("bounds", "exceed min and max, set NaN", refusals.check_bounds_kept),
    Check("misuse", "wrong order and references", refusals.check_misuse),
)

CHECKS = {check.name: check for check in BEHAVIOUR}
ALONE = frozenset(check.name for check in BEHAVIOUR if check.alone)
"""Names of the checks that begin in a process of their own."""
