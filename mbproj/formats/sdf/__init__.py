"""The reader of SDF: scopes with includes, frames by name, and a graph of joints from which a tree is chosen."""
