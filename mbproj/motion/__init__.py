"""Runs: asks the kernel for the motion, explains how a run ended; the paper's own loop and projections in NumPy."""
