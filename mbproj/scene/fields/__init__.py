"""Fields: the kinds of values in a scene: numbers, choices, vectors, functions, records. A block is made of these."""
