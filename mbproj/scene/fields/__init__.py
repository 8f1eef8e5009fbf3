"""What a value in a scene may be: numbers, choices, vectors, functions, records. A block is made of these."""
