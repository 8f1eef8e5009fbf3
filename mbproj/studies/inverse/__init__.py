"""Inverse dynamics: the forces and torques of chosen actuators that produce a given motion."""
