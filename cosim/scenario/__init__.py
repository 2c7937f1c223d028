"""Systems with their inputs, runs and variants, as files: TOML, SSP archives, containers."""
