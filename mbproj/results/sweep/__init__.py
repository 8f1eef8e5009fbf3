"""The summary of a sweep, summary.h5: its names, and its reader."""
