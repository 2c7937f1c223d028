"""Steps: the algorithms, the runs that take them, and where they are recorded."""
