"""Compiles a scene to a System: names become indices, joints become primitives bound to bodies."""
