"""The `curves` block, and rules on what follows a curve."""
