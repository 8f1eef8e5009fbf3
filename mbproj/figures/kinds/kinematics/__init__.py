"""The transmission of a mechanism: ratios of speeds and forces to an input, and transmission angles."""
