"""The reporting of a run: its counts, the error where it cannot go on, its report, and marks from which it
continues."""
