"""The blocks `signals`, `states` and `controllers`, and the names that expressions may use."""
