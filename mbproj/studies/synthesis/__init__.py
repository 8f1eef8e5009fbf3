"""Synthesis: from a path, a function or positions of a body to mechanisms of known topologies."""
