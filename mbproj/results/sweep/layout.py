"""What stands in summary.h5: arrays over what varies, and how each case ended."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType

#: The file in the folder of a sweep.
NAME = "summary.h5"
FORMAT, SCHEMA_VERSION = "mbproj sweep", 2
#: The version in which nothing has a checksum.
WITHOUT_CHECKSUMS = 1
#: The dimension of designs that are not grids.
CASE = "case"
#: Words for how cases ended: measured, and not run yet.
DONE, NOT_RUN = "done", "not run"
#: What is said of each case beside its measures: a description, and how it is found.
ENDINGS: Mapping[str, str] = MappingProxyType(
    {
        "status": "how the case ended: done, failed, timeout, crashed, not run",
        "message": "why it failed",
        "time": "when it failed, in simulated time",
        "joint": "where it failed",
        "seconds": "how long it took, by the clock",
    }
)
