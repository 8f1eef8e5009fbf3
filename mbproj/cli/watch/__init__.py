"""What `mbproj watch` does: a scene is run at each save of it, and a server shows its page to one browser."""
