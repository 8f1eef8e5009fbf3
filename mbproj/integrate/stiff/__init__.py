"""Stiff forces: the fastest modes of a mechanism, and their effect on the steps of a run."""
