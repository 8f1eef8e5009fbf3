"""The blocks of a scene file, one file each, and rules that concern several. A key is an entry of its block's table."""
