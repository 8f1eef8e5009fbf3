"""MJCF, compiled by MuJoCo: its source with includes, then each of its elements as parts of a scene."""
