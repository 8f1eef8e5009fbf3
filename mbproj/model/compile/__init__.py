"""Names become indices, joints become primitives bound to bodies, forces become arrays."""
