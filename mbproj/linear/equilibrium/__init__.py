"""Equilibria of a mechanism, at rest or in a steady turn: force balance on the constraints, by a globalised Newton
iteration."""
