"""Converts samples of a run to the quantities of a results file."""
