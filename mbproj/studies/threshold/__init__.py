"""The violation above which a projection is worth its cost."""
