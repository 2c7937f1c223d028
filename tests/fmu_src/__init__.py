"""Tests of what goes into the FMUs and of what builds them."""
