"""Planar scenes: where the joints alone keep every body in a plane, three coordinates a body are enough."""
