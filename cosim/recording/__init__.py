"""Values at communication points, from the memory in which slaves leave them to the result of a run."""
