"""Variants of a scene: moved, in other units, in another order, or with one quantity changed. Each is a new scene."""
