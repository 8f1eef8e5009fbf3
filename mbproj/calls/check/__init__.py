"""What a scene is, whether it closes, and whether it can run: `mbproj.check`."""
