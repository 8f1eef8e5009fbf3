"""What a mechanism transmits: ratios of speeds and forces to an input, transmission angles."""
