"""Assembly: the consistent start that is nearest to what the scene guesses."""
