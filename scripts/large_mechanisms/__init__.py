"""Scenes of hundreds to thousands of bodies, and what each phase of a command costs in them."""
