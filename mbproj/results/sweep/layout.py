"""The layout of summary.h5: arrays over the quantities that vary, and the ending of each case."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType

#: The file in the folder of a sweep.
NAME = "summary.h5"
FORMAT, SCHEMA_VERSION = "mbproj sweep", 2
#: The version of files without checksums.
WITHOUT_CHECKSUMS = 1
#: The designs of a sweep whose values are samples of distributions.
SAMPLED = frozenset({"montecarlo", "lhs", "sobol", "saltelli"})
#: The dimension of designs that are not grids.
CASE = "case"
#: The endings of cases that were measured, and of those that have not run yet.
DONE, NOT_RUN = "done", "not run"
#: The texts on each case beside its measures, by name, with their descriptions.
ENDINGS: Mapping[str, str] = MappingProxyType(
    {
        "status": "how the case ended: done, failed, timeout, crashed, not run",
        "message": "why it failed",
        "time": "when it failed, in simulated time",
        "joint": "where it failed",
        "seconds": "how long it took, by the clock",
    }
)
