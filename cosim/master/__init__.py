"""The master: it steps slaves from communication point to communication point and exchanges their values."""
