"""The results file (HDF5): `ResultsWriter` writes it in blocks during a run, `open_results` reads it.

The names are imported when they are first used: a run needs few of them.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from mbproj.registry import lazily

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

__getattr__ = lazily(
    __name__,
    {
        "check": "Soundness check_results",
        "crash_safety.checkpoint": "SLOTS",
        "faults": "OutputError",
        "file.checksums": "stamp_attributes",
        "files": "check_output part_path",
        "layout": "DATASETS Dataset LATER",
        "linear.model_file": "read_model",
        "linear.modes_file": "LAYOUT read_modes write_modes",
        "reader": "open_own_results open_results",
        "record": "Results",
        "sweep.table": "Column SweepCases read_table",
        "trust": "Poses Trust",
        "verification": "Check Verification",
        "views.frames": "AXES columns",
        "writer": "Names ResultsWriter",
    },
)
