"""The parameters of the drillstring, at their older address: `models.plant.parameters`."""

from .plant.parameters import DrillstringParameters

__all__ = ["DrillstringParameters"]
