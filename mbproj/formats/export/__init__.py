"""Scenes as models of other formats, MJCF and URDF: a tree with its loops beside it, and a table of what they lack."""
