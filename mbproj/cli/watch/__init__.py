"""The parts of `mbproj watch`: a scene is run at each save, and a server shows its page to one browser."""
