"""Compile, bundle, describe, try and pack the FMUs."""
