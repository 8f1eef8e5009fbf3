"""The `forces` block: the keys of each type of force; and the limits of joints, which are stops too."""
