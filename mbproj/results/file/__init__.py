"""The bytes of a results file: opened, looked over and read here and nowhere else: a file may come from anybody.

Nothing outside this folder touches h5py for reading; `Contents` is what the rest of `results` works with.
"""

from __future__ import annotations

import platform
from contextlib import suppress


def _import_hdf5() -> None:
    """h5py asks for all that `platform.uname()` knows when it is imported, and the processor's name is asked of a child
    process, 25 ms for what it does not use. It finds an empty name in its place; whoever asks later gets the true one.
    """
    with suppress(TypeError):  # a Python whose answer keeps nothing
        known = vars(platform.uname())
        if "processor" not in known:
            known["processor"] = ""
            import h5py  # noqa: F401

            del known["processor"]


_import_hdf5()
