"""The trust horizon of a run: how long it agrees with a better solution of the same equations."""
