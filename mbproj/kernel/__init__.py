"""The compiled core, where there is one: `_core` runs everywhere, `_core_v3` on processors with AVX2 and FMA.

Nothing is loaded before it is asked for. Without a C++ compiler, with an extension that does not load, or where the
environment says MBPROJ_KERNEL=0, mbproj runs without it.
"""

from __future__ import annotations

import os
from functools import cache
from importlib import import_module
from types import ModuleType

from mbproj.version import __version__

__all__ = ["build_info", "core", "fingerprint", "left_out"]


def core() -> ModuleType | None:
    """The extension for this processor, or None where there is none; `build_info` says why."""
    found = _chosen()
    return found if isinstance(found, ModuleType) else None


def build_info() -> dict[str, str] | str:
    """How the extension was compiled (compiler, flags, build type, Eigen, instruction set), or why there is none."""
    found = _chosen()
    return dict(found.build_info()) if isinstance(found, ModuleType) else found


def fingerprint() -> str:
    """What decides the last bits of a run, in one line."""
    import numpy as np

    kernel = build_info()
    built = "no kernel" if isinstance(kernel, str) else f"{kernel['compiler']} for {kernel['instruction_set']}"
    return f"mbproj {__version__} ({built}, numpy {np.__version__})"


def left_out() -> bool:
    """Whether the user wants no kernel, as during the installation."""
    return os.environ.get("MBPROJ_KERNEL", "").lower() in ("0", "no", "off", "false")


@cache
def _chosen() -> ModuleType | str:
    """The extension, or why there is none. The baseline one is loaded first, because it can ask the processor."""
    if left_out():
        return "MBPROJ_KERNEL leaves it out"
    baseline = _imported("_core")
    if isinstance(baseline, str) or not baseline.runs_v3():
        return baseline
    faster = _imported("_core_v3")
    return baseline if isinstance(faster, str) else faster


def _imported(name: str) -> ModuleType | str:
    """The extension of this name, or why it cannot be had."""
    full_name = f"{__name__}.{name}"
    try:
        return import_module(full_name)
    except ImportError as error:
        if isinstance(error, ModuleNotFoundError) and error.name == full_name:
            return "not built"
        return f"failed to import: {error}"
