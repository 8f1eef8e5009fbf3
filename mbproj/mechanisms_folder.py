"""Where the example mechanisms are: in the installed package, or beside it in a checkout."""

from __future__ import annotations

from pathlib import Path


def mechanisms() -> list[Path]:
    """The example scenes, by name."""
    package = Path(__file__).parent
    for folder in (package / "mechanisms", package.parent / "mechanisms"):
        if folder.is_dir():
            return sorted(folder.glob("*.yaml"))
    raise FileNotFoundError("the example mechanisms are not installed")


def mechanism(name: str) -> Path:
    """The example scene of this name, without its ending."""
    return next(path for path in mechanisms() if path.stem == name)
