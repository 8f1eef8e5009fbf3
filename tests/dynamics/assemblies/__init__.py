"""Assemblies of mechanisms, against the numbers that are known of their kinds."""
