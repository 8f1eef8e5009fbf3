"""Bytes become lines, and YAML becomes nodes with their places."""
