"""The trust horizon: how long a run agrees with a better solution of the same equations."""
