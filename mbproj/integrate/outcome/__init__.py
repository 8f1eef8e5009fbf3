"""The end of a run: its counts, the cause where it cannot go on, and its report."""
