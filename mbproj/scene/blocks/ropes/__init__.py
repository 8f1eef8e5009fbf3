"""Ropes: the keys of a rope in a scene, its path, and the rules on both."""
