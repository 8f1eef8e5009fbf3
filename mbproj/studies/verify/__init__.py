"""Verification: what the paper's mathematics says of a mechanism, computed on it, here, and held against round-off."""

from mbproj.studies.verify.checks import verify

__all__ = ["verify"]
