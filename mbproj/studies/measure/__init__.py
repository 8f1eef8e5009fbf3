"""Measuring, for every study: a mechanism, a setting, its solution, a reference for it, the cost."""
