"""Keeps results whole when a run is killed, the disk fills up or two runs choose one file. Only `writer` and `files`
use it."""
