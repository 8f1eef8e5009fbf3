"""The kinematics of a run: passages of coordinates, ratios of speeds, transmission angles."""
