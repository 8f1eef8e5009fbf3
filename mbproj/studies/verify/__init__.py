"""Verification: checks that the paper's identities and the laws of mechanics hold on a given mechanism."""
