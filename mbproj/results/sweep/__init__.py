"""The summary of a sweep, summary.h5: the names in it, and how it is read."""
