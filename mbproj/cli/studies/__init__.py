"""Commands that run many simulations, one file each with the object `command`."""
