"""The report of `mbproj info --build`: versions of the software, and how the kernel was compiled."""

from __future__ import annotations

import platform
from collections.abc import Iterator
from typing import Any

from mbproj.cli.report.text import table
from mbproj.kernel import build_info, left_out
from mbproj.kernel.absence import advice
from mbproj.plugins import installed
from mbproj.registry import FORMULATIONS
from mbproj.version import __version__


def facts() -> dict[str, Any]:
    """The versions, the formulations that can run here, and the kernel's build. Without a kernel, `reason` tells why
    and `advice` what to do."""
    import h5py
    import numpy as np

    kernel = build_info()
    return {
        "mbproj": __version__,
        "python": platform.python_version(),
        "numpy": np.__version__,
        "h5py": h5py.__version__,
        "formulations": ["full"] if isinstance(kernel, str) else [name for name in FORMULATIONS if name != "auto"],
        "plugins": installed(),
        "kernel": _absent(kernel) if isinstance(kernel, str) else {"built": True, **kernel},
    }


def _absent(reason: str) -> dict[str, Any]:
    return {"built": False, "reason": reason, "advice": None if left_out() else advice()}


def lines() -> Iterator[str]:
    """Yield the facts as lines of text."""
    has = facts()
    kernel = has.pop("kernel")
    has["formulations"] = ", ".join(has["formulations"])
    kinds = has.pop("plugins")
    for kind, members in kinds.items():
        has[f"{kind}s"] = ", ".join(f"{name} (from {module})" for name, module in members.items())
    has["kernel"] = kernel["instruction_set"] if kernel["built"] else f"none: {kernel['reason']}"
    yield from table(has)
    if not kernel["built"] and kernel["advice"]:
        yield f"  {kernel['advice']}"
    if kernel["built"]:
        yield from table({key: kernel[key] for key in ("compiler", "build_type", "flags", "eigen")}, "  ")
