"""Inverse dynamics: the forces and torques of chosen actuators along a motion that is given."""
