"""The blocks of a scene, one file each, and the rules between them. A key is an entry of its block's table."""
