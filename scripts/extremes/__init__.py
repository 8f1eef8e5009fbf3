"""Mechanisms at the extremes of size, mass and speed, and how they are tried."""
