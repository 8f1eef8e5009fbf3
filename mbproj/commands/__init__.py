"""The command line `mbproj COMMAND`, one file each command or family, and the same as Python functions."""
