"""Commands on one scene or results file, one file each with the object `command`."""
