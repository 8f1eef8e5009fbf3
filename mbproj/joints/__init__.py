"""Joint types as data, and the constraint primitives that their rows are."""
