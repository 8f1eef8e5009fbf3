"""Opens, checks and reads the bytes of a results file. No other folder does, since a file may come from anybody.

Nothing outside this folder touches h5py for reading; `Contents` is what the rest of `results` works with.
"""

from __future__ import annotations

import platform
from contextlib import suppress
from importlib import import_module


def _import_hdf5() -> None:
    """Import h5py without a search for the processor's name. h5py asks for all of `platform.uname()`, for which a child
    process runs 25 ms; h5py does not use it. It gets an empty name, and later callers get the true one."""
    with suppress(TypeError):  # some versions of Python do not cache the answer
        known = vars(platform.uname())
        if "processor" not in known:
            known["processor"] = ""
            import_module("h5py")
            del known["processor"]


_import_hdf5()
