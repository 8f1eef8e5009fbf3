"""Dry friction at a state: the loads of bearings, and which frictions stick or slide. The time loop finds when that
changes."""
