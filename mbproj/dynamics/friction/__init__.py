"""Dry friction at a state: what bearings carry, what sticks and what slides. When that changes is for the time loop."""
