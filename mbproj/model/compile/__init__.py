"""Scene to System: names become indices, joints become primitives that are bound to bodies."""
