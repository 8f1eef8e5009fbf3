"""The report of `mbproj.check`: what a scene consists of, whether it closes, and whether it can run."""
