"""Loads over the cycle: the polar diagrams of bearings, and driving forces over the angle."""
