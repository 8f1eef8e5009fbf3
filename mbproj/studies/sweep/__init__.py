"""Sweeps: a family of mechanisms, each a case that is run once, measured, and kept."""
