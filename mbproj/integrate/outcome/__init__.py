"""How a run ends: what it counted, why it cannot go on, and what it says of itself."""
