"""Tune laws against stick-slip: gains searched for by what the FMUs do, within what the linear model allows."""
