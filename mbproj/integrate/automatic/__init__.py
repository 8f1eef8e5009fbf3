"""The choice of `integrator: auto`: an explicit method until a force slows it down, an implicit one until none does."""
