"""The common part of all projection methods: when to project, the iteration to C = 0, its damping and tolerance."""
