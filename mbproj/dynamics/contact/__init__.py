"""Stops at one state, on top of the constraints: gaps, impacts and contact forces. The time loop finds when they
act."""
