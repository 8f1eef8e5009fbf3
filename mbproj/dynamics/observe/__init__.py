"""From samples of a run to what a results file holds."""
