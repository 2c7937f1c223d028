"""Stability of the running equilibrium: neutral forms, roots, charts."""
