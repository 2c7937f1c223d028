"""The mathematics in readable Python: the executable specification of what the FMUs compute.

Everything here uses + - * / and sqrt on floats in a fixed order, so that the C core can repeat it operation by
operation and give the same bits. No numpy, no libm functions, no compensated ``sum``, no ``**`` in code that must match.
"""
