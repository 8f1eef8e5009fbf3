"""Mechanisms whose numbers `scripts/find_designs.py` finds."""
