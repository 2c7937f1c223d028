"""The numerics that plants and laws share, operation by operation as in the C core."""
