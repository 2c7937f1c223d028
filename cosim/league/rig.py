"""Put a law on a rig: driller, law, drive with its sensors, and string, each an FMU, connected by the names they have.

What a law takes is connected to whoever tells it: references to the driller, speeds and torque at the top to the
sensors of the drive, what is known at the bit to the string. What it gives goes to the drive or, a weight, to the
string. So a law of one's own takes part as it is.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

from cosim.errors import ScenarioError
from cosim.fmi2.locate import locate_fmu
from cosim.fmi2.model_description import read_description
from cosim.league.entries import Condition, Law, League
from cosim.scenario.scenario import Scenario
from cosim.system.description import Description
from cosim.system.method import Method
from cosim.system.signals import Signal, Step, Value
from cosim.system.structure import Component, Connection, System

PLANT, PROGRAM, DRIVE = "DrillstringNeutral", "DrillingProgram", "TopDrive"
_TOLD = {
    "speed_ref": "program.speed_ref",
    "bit_speed_ref": "program.bit_speed_ref",
    "bit_torque_ref": "program.bit_torque_ref",
    "top_speed": "drive.top_speed_measured",
    "top_torque": "drive.top_torque_measured",
    "Omega": "drive.Omega_measured",
    "bit_speed": "plant.bit_speed",
    "bit_torque": "plant.bit_torque",
}
"""Who tells what laws take."""
_TAKEN = {"Omega": "drive.Omega_command", "motor_torque": "drive.motor_torque", "WOB": "plant.WOB"}
"""Where goes what laws give."""
ENABLED = "enabled"


class Rig:
    """A law under a condition, as a scenario.

    Parameters
    ----------
    league : League
        How long to run, and in which steps.
    law : Law
        The law.
    condition : Condition
        What it is judged under.

    Attributes
    ----------
    scenario : Scenario
        To be run.
    engaged : float
        From when on the law is judged [s].
    switched : bool
        The law is switched on then; one without a switch acts from rest.
    loaded : float or None
        Until when the weight rises from then on; None if it is there from the start.

    Raises
    ------
    InputError
        If the law cannot be connected, or a parameter does not exist.
    """

    def __init__(self, league: League, law: Law, condition: Condition) -> None:
        self._law, self._condition = law, condition
        self.engaged = league.settle
        self.loaded = league.settle + condition.load_time if condition.load_time > 0.0 else None
        described = self._described(league.folder) if law.fmu else None
        inputs = self._inputs(described)
        self.switched = not law.fmu or bool(inputs)
        connections = self._connections(described)
        self.scenario = Scenario(
            name=f"{law.name}-{condition.name}",
            system=System(
                components=tuple(self._components(described)),
                connections=tuple(Connection(source, target) for target, source in connections.items()),
                inputs=inputs,
            ),
            stop_time=league.settle + league.judge,
            step_size=league.step_size,
            method=Method(algorithm="gauss-seidel"),
            folder=league.folder,
        )

    def _described(self, folder: Path) -> Description:
        """Read the description of the law."""
        return read_description(locate_fmu(self._law.fmu, "native", folder))

    def _components(self, described: Description | None) -> list[Component]:
        """Return driller, drive, string and law, with their parameters."""
        law, condition = self._law, self._condition
        first = 0.0 if self.loaded is not None else condition.weight
        program: dict[str, Value] = {
            "speed_initial": condition.speed, "speed_final": condition.speed, "WOB_initial": first,
            "WOB_final": condition.weight, "WOB_start": self.engaged, "WOB_duration": condition.load_time,
        }  # fmt: skip
        program |= _shared(read_description(locate_fmu(PROGRAM, "native")), condition.plant)
        components = [
            Component("program", PROGRAM, program),
            Component("drive", DRIVE, {**condition.drive, **law.drive}),
            Component("plant", PLANT, condition.plant),
        ]
        if described is not None:
            known = _shared(described, {**condition.plant, **self._assumed()})
            components.append(Component("law", law.fmu, {**known, **law.parameters}))
        return components

    def _assumed(self) -> dict[str, Value]:
        """Return what laws take parameters of the string for that they are mistaken about."""
        condition = self._condition
        if not condition.assumed:
            return {}
        starts = {v.name: v.start_value for v in read_description(locate_fmu(PLANT, "native")).variables}
        assumed: dict[str, Value] = {}
        for name, multiple in condition.assumed.items():
            value = condition.plant.get(name, starts.get(name))
            if not isinstance(value, int | float):
                raise ScenarioError(f"conditions.{condition.name}.assumed: the string has no number '{name}'")
            assumed[name] = multiple * value
        return assumed

    def _connections(self, described: Description | None) -> dict[str, str]:
        """Return sources by target."""
        found = {
            "drive.top_speed": "plant.top_speed",
            "drive.top_torque": "plant.top_torque",
            "plant.Omega": "drive.Omega",
            "plant.WOB": "program.WOB",
            "drive.Omega_command": "program.speed_ref",
        }
        if described is None:
            return found
        given = [v.name for v in described.variables if v.causality == "output" and v.name in _TAKEN]
        if not given:
            raise ScenarioError(f"law '{self._law.name}' gives none of {', '.join(_TAKEN)}; expected one as an output")
        for variable in described.variables:
            if variable.causality == "input" and variable.name in _TOLD:
                found[f"law.{variable.name}"] = _TOLD[variable.name]
        found |= {_TAKEN[name]: f"law.{name}" for name in given}
        if "motor_torque" in given:
            del found["drive.Omega_command"]
        return found

    def _inputs(self, described: Description | None) -> dict[str, Signal | float]:
        """Return what switches the law on."""
        names = {v.name for v in described.variables if v.causality == "input"} if described else set[str]()
        if ENABLED not in names:
            return {}
        before = self.loaded is not None
        return {f"law.{ENABLED}": Step(before, True, self.engaged)}


def _shared(described: Description, string: Mapping[str, Value]) -> dict[str, Value]:
    """Return the parameters of the string that another FMU has too."""
    return {v.name: string[v.name] for v in described.variables if v.name in string and v.causality == "parameter"}
