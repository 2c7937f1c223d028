"""Loops of components that depend on each other: closing them, and saying when, where and why one does not close."""
