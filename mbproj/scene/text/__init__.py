"""The scene's text: bytes to lines, YAML to nodes with their places, changes that keep every other character."""
