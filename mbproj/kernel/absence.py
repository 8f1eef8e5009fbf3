"""What to say where the kernel is missing: which mbproj was imported, and what to do for one that has a kernel."""

from __future__ import annotations

from pathlib import Path

from mbproj.errors import warn_once
from mbproj.kernel import left_out


def warn_of_absence(reason: str) -> None:
    """Says once what the missing kernel costs, unless it is left out on purpose."""
    if not left_out():
        cost = "so that simulations run in the full formulation, some hundred times slower"
        warn_once(f"the compiled kernel is missing ({reason}), {cost}: {advice()}")


def advice() -> str:
    """What to do for a kernel."""
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
    """The folder of the package as pip installed it; None without one, or where that is made of the sources."""
    from importlib import metadata  # takes 20 ms, and only a missing kernel asks for it

    try:
        folder = Path(str(metadata.distribution("mbproj").locate_file("mbproj")))
    except metadata.PackageNotFoundError:
        return None
    return folder.absolute() if (folder / "__init__.py").exists() else None
