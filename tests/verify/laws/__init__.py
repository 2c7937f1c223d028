"""The laws, a module for each kind; importing this enters them into the list, in the order of the report."""

from tests.verify.finding import LAWS
from tests.verify.laws import damping, energy, field, intervals, limits, printed, spectra, steps, symmetry

ORDER = [kind.__name__ for kind in (steps, field, damping, intervals, spectra, energy, symmetry, limits, printed)]
LAWS.sort(key=lambda law: ORDER.index(law.examine.__module__))
