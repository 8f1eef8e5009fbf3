"""The commands that simulate one scene: run, rerun, continue and others."""
