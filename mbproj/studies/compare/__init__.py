"""Chosen methods on one mechanism, side by side."""
