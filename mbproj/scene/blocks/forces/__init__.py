"""The `forces` block: what each type of force is written as; limits of joints, which are stops too."""
