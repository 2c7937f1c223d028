"""Judge laws against stick-slip on one bench: each law under each condition, through the FMUs, into one table."""
