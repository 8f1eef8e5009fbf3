"""URDF, read by ourselves: the tree, and the loops that stand beside it in several dialects."""
