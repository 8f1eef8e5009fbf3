"""Designs: numbers of a scene that match measurements, or make a measure as small or as large as possible."""
