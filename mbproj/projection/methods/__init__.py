"""The paper's projection methods, one file each. A new one is a file here and an entry of the registry."""
