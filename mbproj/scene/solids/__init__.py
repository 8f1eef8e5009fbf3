"""What bodies are made of and look like: shapes with their mass and inertia, and appearances. A shape is an entry."""
