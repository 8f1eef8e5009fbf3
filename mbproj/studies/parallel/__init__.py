"""Many simulations at once: worker processes, a cluster, progress, and results that are stored as they come."""
