"""What the kinematics of a mechanism are: passages of coordinates, ratios of speeds, transmission angles."""
