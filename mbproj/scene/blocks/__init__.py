"""The blocks of a scene file: the field of each key, and the rules that a block keeps."""
