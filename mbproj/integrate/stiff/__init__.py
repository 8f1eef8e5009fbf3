"""Stiff forces: the fastest modes of a mechanism, and what they do to the steps of a run."""
