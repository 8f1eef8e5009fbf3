"""The numerical examples of the paper."""
