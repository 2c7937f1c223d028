"""Tests of the drillstring co-simulation."""
