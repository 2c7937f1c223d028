"""Names and media types of the SSP 1.0 standard, and of the annotations of this package."""

from __future__ import annotations

SSD = "http://ssp-standard.org/SSP1/SystemStructureDescription"
SSC = "http://ssp-standard.org/SSP1/SystemStructureCommon"
SSV = "http://ssp-standard.org/SSP1/SystemStructureParameterValues"
OWN = "urn:drillstring-cosim:ssp:1"

STRUCTURE = "SystemStructure.ssd"
RESOURCES = "resources"

FMU_TYPE = "application/x-fmu-sharedlibrary"
PARAMETER_SET_TYPE = "application/x-ssp-parameter-set"

SCENARIO_ANNOTATION = "drillstring-cosim.scenario.scenario"
"""On the whole description: how the system is to be run."""
SIGNALS_ANNOTATION = "drillstring-cosim.system.signals"
"""On a component: it stands for signals that drive inputs, and nothing else."""


def ssd(name: str) -> str:
    """Return the qualified name of an element of a system structure description."""
    return f"{{{SSD}}}{name}"


def ssc(name: str) -> str:
    """Return the qualified name of an element that all formats of the standard share."""
    return f"{{{SSC}}}{name}"


def ssv(name: str) -> str:
    """Return the qualified name of an element of a parameter set."""
    return f"{{{SSV}}}{name}"


def own(name: str) -> str:
    """Return the qualified name of an element of this package's annotations."""
    return f"{{{OWN}}}{name}"
