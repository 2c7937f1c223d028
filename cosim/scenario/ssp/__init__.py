"""Systems in the exchange format of System Structure and Parameterization (SSP) 1.0.

An .ssp file is a zip archive with the description of a system, SystemStructure.ssd, and in `resources` the FMUs and
their parameter sets, .ssv. What the standard has no word for goes into annotations, which other tools ignore.
"""
