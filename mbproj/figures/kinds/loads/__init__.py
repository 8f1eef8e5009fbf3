"""Loads over the cycle: polar diagrams of bearings, driving forces over the angle, and tensions of ropes."""
