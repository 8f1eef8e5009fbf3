"""Writes scenes as MJCF and URDF: a tree with its loops beside it, and a table of what is left out."""
