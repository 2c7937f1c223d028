"""The reference experiments that travel inside every FMU: what is done to it, and what it must answer.

The answers share no code with what they judge: those of the plant come from `tests.oracle`, those of laws and program
from closed forms in decimal arithmetic. ``python -m tests.reference`` writes them into the folders of the FMUs.
"""
