"""The mathematics in readable Python: the executable specification of what the FMUs compute, and the theory of it.

What the FMUs compute uses + - * / and sqrt on floats in a fixed order, so that the C core can repeat it operation by
operation and give the same bits. Code that must match has no numpy, no libm functions, no ``**`` and no ``sum``, which
compensates since Python 3.12. The theory (equilibria, spectrum, cycles) has no such twin: it uses numpy and scipy, and
nothing that an FMU holds imports it.
"""
