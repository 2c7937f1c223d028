"""The documentation, executed: every block of its pages is run, or examined, and its output compared."""
