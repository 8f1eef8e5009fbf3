"""The reader of SDF: scopes with includes, frames by name, inertias, and a graph of joints with its loops."""
