"""The results file (HDF5): `ResultsWriter` writes it in blocks during a run, `open_results` reads it.

The names are imported when they are first used: a run needs few of them.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from mbproj.results.check import Soundness, check_results
    from mbproj.results.faults import OutputError
    from mbproj.results.files import check_output, part_path
    from mbproj.results.layout import DATASETS, Dataset
    from mbproj.results.reader import open_own_results, open_results
    from mbproj.results.record import Results
    from mbproj.results.trust import Trust
    from mbproj.results.verification import Check, Verification
    from mbproj.results.writer import Names, ResultsWriter

_HOME_OF = {
    **dict.fromkeys(("Soundness", "check_results"), "mbproj.results.check"),
    "OutputError": "mbproj.results.faults",
    **dict.fromkeys(("check_output", "part_path"), "mbproj.results.files"),
    **dict.fromkeys(("DATASETS", "Dataset"), "mbproj.results.layout"),
    **dict.fromkeys(("open_own_results", "open_results"), "mbproj.results.reader"),
    "Results": "mbproj.results.record",
    "Trust": "mbproj.results.trust",
    **dict.fromkeys(("Check", "Verification"), "mbproj.results.verification"),
    **dict.fromkeys(("Names", "ResultsWriter"), "mbproj.results.writer"),
}
__all__ = [
    "DATASETS",
    "Check",
    "Dataset",
    "Names",
    "OutputError",
    "Results",
    "ResultsWriter",
    "Soundness",
    "Trust",
    "Verification",
    "check_output",
    "check_results",
    "open_own_results",
    "open_results",
    "part_path",
]


def __getattr__(name: str) -> Any:
    if name not in _HOME_OF:
        raise AttributeError(f"module 'mbproj.results' has no attribute '{name}'")
    return getattr(import_module(_HOME_OF[name]), name)
