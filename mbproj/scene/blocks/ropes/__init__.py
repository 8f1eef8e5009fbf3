"""Ropes: the keys of their joints, their paths, and rules on both."""
