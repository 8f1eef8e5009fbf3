"""Results files that are damaged or hold nonsense, and the commands that read them.

A finished file, a certified and verified one, and what is left of a killed run are changed: bits, pages and words of
their bytes (`bytes_changed.py`), or their content by HDF5 itself (`contents_changed.py`).
"""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from pathlib import Path
from random import Random

from fuzz.bytes_changed import change_bytes
from fuzz.contents_changed import change_contents
from fuzz.trial import Ending, trial
from mbproj.base.errors import InputError
from mbproj.results.layout import DATASETS
from mbproj.results.reader import open_results
from mbproj.results.record import Results

ROOT = Path(__file__).resolve().parents[2]
ORIGINALS = ("short.h5", "certified.h5", "killed.h5.part")
#: What reads a changed file R, and how often it is drawn: what takes seconds of its own comes rarely.
READERS: dict[tuple[str, ...], int] = {
    ("info", "R"): 6,
    ("info", "R", "--json"): 6,
    ("info", "R", "--check"): 6,
    ("export", "R", "-o", "tables"): 6,
    ("plot", "R", "-o", "pictures", "--kind", "violation", "--kind", "energy"): 2,
    ("rerun", "R", "-o", "again.h5", "--quiet"): 6,
    ("compare-results", "R", "short.h5"): 6,
    ("compare-results", "short.h5", "R"): 6,
    ("verify", "scene.yaml", "--store", "R"): 1,
    ("run", "scene.yaml", "--duration", "0.05", "-o", "R", "--quiet"): 3,
    ("run", "scene.yaml", "--duration", "0.05", "-o", "new.h5", "--quiet"): 3,
}
#: Waits after some samples, so that it can be killed.
KILLED = """
import sys, time
from mbproj.commands.main import main
from mbproj.results.writer import ResultsWriter
write = ResultsWriter._flush
def wait(self):
    write(self)
    if self._samples:
        print("go", flush=True)
        time.sleep(600)
ResultsWriter._flush = wait
sys.argv[1:] = ["run", "scene.yaml", "--duration", "1", "-o", "killed.h5", "--quiet"]
main()
"""


def make_originals(model: Path) -> None:
    """A certified and verified file, and what is left of a run that was killed, beside short.h5."""
    run = ["run", "scene.yaml", "--duration", "0.05", "-o", "certified.h5", "--quiet", "--certify"]
    for arguments in (run, ["verify", "scene.yaml", "--duration", "0.05", "--store", "certified.h5"]):
        ending = trial(arguments, model, "utf-8", None, {})
        assert ending.code == 0, ending.printed
    environment = {**os.environ, "PYTHONPATH": str(ROOT)}
    process = subprocess.Popen([sys.executable, "-c", KILLED], cwd=model, env=environment, stdout=subprocess.PIPE)
    assert process.stdout is not None
    process.stdout.readline()
    process.kill()
    process.wait()


def damaged(folder: Path, random: Random) -> tuple[list[str], str]:
    """A command line on a file that was changed in a folder, and how it was."""
    original = random.choice(ORIGINALS)
    arguments = random.choices(list(READERS), list(READERS.values()))[0]
    part = "new.h5" in arguments or original.endswith(".part")
    name = "new.h5.part" if part else "changed.h5"
    shutil.copyfile(folder / original, folder / name)
    in_bytes = random.random() < 0.5 or original.endswith(".part")
    how = (change_bytes if in_bytes else change_contents)(folder / name, random)
    shutil.copyfile(folder / name, folder / "changed.bin")
    return [name if word == "R" else word for word in arguments], f"{original}, {how}"


def wrong_numbers(folder: Path, arguments: list[str], how: str, ending: Ending) -> str:
    """What is wrong where `info --check` calls a finished file with flipped bits sound whose numbers are others. (A
    killed run's file has Fletcher-32 alone, which takes 16 ones for 16 zeros.)"""
    original, change = how.split(", ", 1)
    by_bytes = change.partition(":")[0] in ("bits", "page", "cut", "moved", "word", "left_open", "resealed")
    if "--check" not in arguments or ending.code or not by_bytes or original.endswith(".part"):
        return ""
    try:
        with open_results(folder / original) as one, open_results(folder / "changed.bin") as other:
            return "" if _all(one) == _all(other) else "other numbers pass"
    except InputError:
        return "other numbers pass"


def _all(results: Results) -> list[object]:
    series: list[object] = [results[dataset.path].tobytes() for dataset in DATASETS]
    attributes = dict(results.attributes)
    return [*series, results.settings, results.overrides, results.scene_text, results.names("joints"), attributes]
