"""Run a scenario over grids, lists and samples of what can be set, on every core or a cluster."""
