"""Pictures of results, of studies and of sweeps, by matplotlib."""
