"""Numerical tools of the theory: interpolation and counting of zeros."""
