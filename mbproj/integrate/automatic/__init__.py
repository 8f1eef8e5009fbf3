"""The choice of `integrator: auto`: an explicit method until a force holds it up, an implicit one until none does."""
