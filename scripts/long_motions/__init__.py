"""What scripts/long_energy.py runs: mechanisms, their exact motions, and symplectic methods beside mbproj's."""
