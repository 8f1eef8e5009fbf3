"""Runs of many scenes at once: scenes that differ only in numbers are prepared and measured as arrays."""
