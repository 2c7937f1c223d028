"""Step slaves from communication point to communication point, and exchange their values."""
