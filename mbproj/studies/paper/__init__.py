"""The numerical examples of the paper, computed again."""
