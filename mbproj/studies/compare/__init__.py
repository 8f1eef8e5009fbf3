"""The comparison of chosen settings on one mechanism, side by side."""
