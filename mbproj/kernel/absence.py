"""The warning of a missing kernel, and advice for an installation that has one."""

from __future__ import annotations

from pathlib import Path

from mbproj.errors import warn_once
from mbproj.kernel import left_out


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
