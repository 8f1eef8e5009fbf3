"""Equilibria of a mechanism, at rest or in a steady turn: forces in balance on the constraints."""
