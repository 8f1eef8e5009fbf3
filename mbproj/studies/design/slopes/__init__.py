"""Slopes of what runs are measured by: dual numbers along one run, or differences of runs."""
