"""Scenarios by name, or from a file of either kind."""

from __future__ import annotations

from collections.abc import Generator
from contextlib import contextmanager
from pathlib import Path

from cosim.scenario.scenario import Scenario
from cosim.scenario.scenario_file import load_scenario
from cosim.scenario.ssp.reading import open_ssp


@contextmanager
def opened_scenario(source: str, stop_time: float | None = None, step_size: float | None = None) -> Generator[Scenario]:
    """Load a scenario for as long as it is needed.

    Parameters
    ----------
    source : str
        A name such as ``"stick-slip"``, or the path of a .toml or .ssp file.
    stop_time, step_size : float, optional
        In s; for .ssp files that do not give them.

    Raises
    ------
    InputError
        If there is none, or it cannot be understood.
    """
    if Path(source).suffix != ".ssp":
        yield load_scenario(source)
        return
    with open_ssp(source, stop_time=stop_time, step_size=step_size) as loaded:
        yield loaded
