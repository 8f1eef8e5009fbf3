"""The threshold study: the violation above which a projection is worth its cost."""
