"""MJCF, compiled by MuJoCo: its source with includes and without missing assets, then each kind of element."""
