"""The compiled core, the extension `_core`, where there is one.

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
    """The extension, or None where there is none; `build_info` says why."""
    loaded = _loaded()
    return loaded if isinstance(loaded, ModuleType) else None


def build_info() -> dict[str, str] | str:
    """How the extension was compiled (compiler, flags, build type, Eigen, instruction set), or why there is none."""
    loaded = _loaded()
    return dict(loaded.build_info()) if isinstance(loaded, ModuleType) else loaded


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
def _loaded() -> ModuleType | str:
    """The extension, or why there is none."""
    if left_out():
        return "MBPROJ_KERNEL leaves it out"
    name = "mbproj.kernel._core"
    try:
        return import_module(name)
    except ImportError as error:
        if isinstance(error, ModuleNotFoundError) and error.name == name:
            return "not built"
        return f"failed to import: {error}"
