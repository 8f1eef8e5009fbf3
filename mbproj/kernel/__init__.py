"""The compiled core, the extension `_core`, where there is one, and the models that it gets."""

from __future__ import annotations

import os
from functools import cache
from importlib import import_module
from pathlib import Path
from types import ModuleType

from mbproj.base.errors import warn_once
from mbproj.base.version import __version__

# --- The compiled core, the extension `_core`, where there is one -----------------------------------------------------
# Nothing is loaded before it is asked for. Without a C++ compiler, with an extension that does not load, or where the
# environment says MBPROJ_KERNEL=0, mbproj runs without it.


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


# --- The warning of a missing kernel, and advice for an installation that has one -------------------------------------


def warn_of_absence(reason: str) -> None:
    """Warns once that the kernel is missing, with the cost, unless it is left out on purpose."""
    if not left_out():
        cost = "so that simulations run in the full formulation, some hundred times slower"
        warn_once(f"the compiled kernel is missing ({reason}), {cost}: {advice()}")


def advice() -> str:
    """Return the advice how to get a kernel."""
    package = _package()
    if not (package / "kernel" / "src").is_dir():  # sources of the kernel are not installed
        why = "pip says why it does not compile where MBPROJ_KERNEL=1 is set"
        return f"install again with --force-reinstall: {why}; or set MBPROJ_KERNEL=0 to do without"
    other = _installed()
    if other is not None and other != package:
        return f"Python took the sources in '{package}', not the installed '{other}': start it in another folder"
    return (
        f"Python took the sources in '{package}': pip install -e '{package.parent}'; "
        "or set MBPROJ_KERNEL=0 to do without"
    )


def _package() -> Path:
    return Path(__file__).absolute().parents[1]


def _installed() -> Path | None:
    """Return the folder of the package that pip installed; None without one, or for an installation of the sources
    themselves."""
    from importlib import metadata  # takes 20 ms, and is needed only without a kernel

    try:
        folder = Path(str(metadata.distribution("mbproj").locate_file("mbproj")))
    except metadata.PackageNotFoundError:
        return None
    return folder.absolute() if (folder / "__init__.py").exists() else None
