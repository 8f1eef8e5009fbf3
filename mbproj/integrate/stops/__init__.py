"""Runs of mechanisms with stops: legs between the times at which something is struck, held or released."""
