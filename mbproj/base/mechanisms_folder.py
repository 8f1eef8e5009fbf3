"""The folder of the example mechanisms: in the installed package, or beside it in a checkout."""

from __future__ import annotations

from pathlib import Path


def folder() -> Path:
    """The folder of the example scenes; its folder `validation` has scenes with results of other programs."""
    package = Path(__file__).parents[1]
    for place in (package / "mechanisms", package.parent / "mechanisms"):
        if place.is_dir():
            return place
    raise FileNotFoundError("the example mechanisms are not installed")


def mechanisms() -> list[Path]:
    """The example scenes, by name."""
    return sorted(folder().glob("*.yaml"))


def validation_scenes() -> list[Path]:
    """The scenes that mbproj is validated with, by name."""
    return sorted((folder() / "validation").glob("*.yaml"))


def mechanism(name: str) -> Path:
    """The example scene of this name, without its ending."""
    return next(path for path in mechanisms() if path.stem == name)
