"""Runs of any length: trajectories that go to disk as they come, checkpoints, and going on from them."""
