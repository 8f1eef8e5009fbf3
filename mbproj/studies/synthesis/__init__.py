"""Synthesis: from a path, a function or positions of a body to mechanisms of known topologies that draw, compute or
carry them. Closed forms look at many designs at once; the ordinary search of designs has the last word."""
