"""The coordinates of a run: full in NumPy, reduced and planar in the kernel, and the choice among them."""
