"""Curves in a plane: pieces with exact derivatives, the foot of a point, arc length; lift laws and their profiles."""
