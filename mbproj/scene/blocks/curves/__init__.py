"""The `curves` block, and rules on the joints that follow a curve."""
