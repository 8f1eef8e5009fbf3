"""Assembly: the consistent initial state nearest to the scene's guess."""
