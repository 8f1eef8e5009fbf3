"""The reader of URDF: the tree, and its loops, for which there are several dialects."""
