"""The results file (HDF5): `ResultsWriter` writes it in blocks during a run, `open_results` reads it."""

from mbproj.results.check import Soundness, check_results
from mbproj.results.faults import OutputError
from mbproj.results.files import check_output, part_path
from mbproj.results.layout import DATASETS, Dataset
from mbproj.results.reader import open_own_results, open_results
from mbproj.results.record import Results
from mbproj.results.trust import Trust
from mbproj.results.verification import Check, Verification
from mbproj.results.writer import Names, ResultsWriter

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
