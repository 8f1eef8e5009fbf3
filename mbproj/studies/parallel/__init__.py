"""Many simulations at once: worker processes, the messages to them, progress, and stored results."""
