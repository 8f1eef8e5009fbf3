"""Writes scenes in the formats MJCF and URDF: a tree with its loops beside it, and a table of what these leave out."""
