"""The time loop: steps, step-size control, projection, samples, interruption."""
