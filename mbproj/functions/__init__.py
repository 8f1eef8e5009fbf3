"""Functions that a scene gives (of time, or of a length and its rate), as flat programs that any language can run."""
