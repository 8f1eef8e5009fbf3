"""Stops at a state: gaps, impacts, forces in contact, all on the constraints. When they come is for the time loop."""
