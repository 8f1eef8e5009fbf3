"""Scene files to begin with, written by `mbproj new`: readable, commented, and with expected results."""
