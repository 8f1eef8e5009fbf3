"""Verification: checks that the paper's identities and the laws of mechanics hold on a given mechanism, to
round-off."""

from mbproj.studies.verify.checks import verify

__all__ = ["verify"]
