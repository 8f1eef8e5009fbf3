"""Many simulations at once: worker processes, what they are sent, how far they are, what is kept."""
