"""What all projection methods share: when to project, the iteration to C = 0, its damping and tolerance."""
