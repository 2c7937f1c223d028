"""Independent reference solution of the torsional drillstring, sharing no code with the product it judges.

A spectral method of steps: each smooth stretch of the bit's motion is a polynomial found by Gauss-Legendre collocation,
and stretches are cut exactly where a jump, a stop or a release arrives, so no error is made at any of them.
"""

from tests.oracle.plant import OracleParameters, Program
from tests.oracle.solution import OracleSolution, solve

__all__ = ["OracleParameters", "OracleSolution", "Program", "solve"]
