"""The bytes of a results file: opened, looked over and read here and nowhere else: a file may come from anybody.

Nothing outside this folder touches h5py for reading; `Contents` is what the rest of `results` works with.
"""

from __future__ import annotations

import platform
from contextlib import suppress
from importlib import import_module


def _import_hdf5() -> None:
    """When h5py is imported, it asks for all that `platform.uname()` knows. A child process finds the processor's name,
    25 ms for what is not used. h5py finds an empty name in its place, and whoever asks later gets the true one."""
    with suppress(TypeError):  # a Python whose answer keeps nothing
        known = vars(platform.uname())
        if "processor" not in known:
            known["processor"] = ""
            import_module("h5py")
            del known["processor"]


_import_hdf5()
