"""Assembly: the consistent state nearest to the scene's guess, all of them, or an error that names the joint."""
