"""Where a mechanism rests, or turns steadily: force balance on the constraints, by a globalised Newton iteration."""
