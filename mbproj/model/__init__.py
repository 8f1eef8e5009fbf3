"""Compiles a scene to the System, which is constant arrays, and to the Guess from which assembly starts."""
