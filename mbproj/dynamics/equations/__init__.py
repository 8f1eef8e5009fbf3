"""The paper's equations at one state: constraints, motion, forces, energy. Pure functions of (t, q, v)."""
