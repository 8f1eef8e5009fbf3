"""Loads over the cycle: polar diagrams of bearings, driving forces over the angle, and the tensions of ropes."""
