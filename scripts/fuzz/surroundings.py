"""The folder that a command line works in, and its environment."""

from __future__ import annotations

import os
import shutil
from pathlib import Path
from random import Random

FOREIGN = {"foreign.txt": b"mine\n", "foreign.csv": b"a,b\n1,2\n"}
#: Variables that mbproj or what it stands on reads, with values that nobody means.
VARIABLES: dict[str, tuple[str, ...]] = {
    "MBPROJ_CACHE": ("", "pipe", "foreign.txt", "/dev/null", "/proc", "q" * 5000, "cache", "dangling", "\udcff"),
    "XDG_CACHE_HOME": ("", "foreign.txt", "/proc"),
    "HOME": ("", "/nowhere", "foreign.txt"),
    "TMPDIR": ("/nowhere", "foreign.txt", ""),
    "COLUMNS": ("0", "-1", "abc", "1", "999999999"),
    "LINES": ("0", "abc"),
    "TERM": ("", "dumb", "\x1b"),
    "NO_COLOR": ("", "1"),
    "OMP_NUM_THREADS": ("abc", "0", "-1", "99999"),
    "OPENBLAS_NUM_THREADS": ("abc", "0", "99999"),
    "LC_ALL": ("C", "xx_YY", "de_DE.ISO-8859-1"),
    "PYTHONIOENCODING": ("latin-1", "cp1252", "ascii", "koi8-r", "utf-8:strict"),
    "PYTHONWARNINGS": ("error",),
    "MPLBACKEND": ("nonsense", "TkAgg"),
    "MPLCONFIGDIR": ("foreign.txt", "/proc"),
    "HDF5_USE_FILE_LOCKING": ("FALSE", "TRUE", "nonsense"),
    "TZ": ("nonsense",),
    "USER": ("\x1b[31m",),
}


def environment(random: Random) -> dict[str, str]:
    """Some of the variables."""
    names = random.sample(list(VARIABLES), random.choice((1, 1, 2, 3)))
    return {name: random.choice(VARIABLES[name]) for name in names}


def furnish(folder: Path, model: Path) -> None:
    """Makes `folder` what a user could have: scenes and results of `model`, and what is neither."""
    for source in model.iterdir():
        shutil.copyfile(source, folder / source.name)
    for name, content in FOREIGN.items():
        (folder / name).write_bytes(content)
    (folder / "empty").touch()
    (folder / "part.h5.part").write_bytes((model / "short.h5").read_bytes()[:3000])
    (folder / "\udcff.yaml").write_bytes((model / "scene.yaml").read_bytes())
    (folder / "\x1b[31m.yaml").write_bytes((model / "scene.yaml").read_bytes())
    os.mkfifo(folder / "pipe")
    (folder / "folder").mkdir()
    (folder / "locked").mkdir(mode=0o500)
    (folder / "link").symlink_to("foreign.txt")
    (folder / "dangling").symlink_to("nowhere")
    (folder / "loop").symlink_to("loop")


def untouched(folder: Path) -> list[str]:
    """What of somebody else's is no longer as it was."""
    return [name for name, content in FOREIGN.items() if (folder / name).read_bytes() != content]
