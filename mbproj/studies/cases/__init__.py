"""Many cases at once: scenes that differ only in numbers are compiled, assembled and measured as one, by arrays."""
