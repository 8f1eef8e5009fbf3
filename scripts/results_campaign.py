"""Results files that are damaged, or hold nonsense, and what the commands that read them make of it.

    python scripts/results_campaign.py [--minutes 10] [--seed 0] [--output build/results-campaign]

Small results files (one finished, one certified and verified, one of a killed run) are changed: bits, pages and words
of their bytes (scripts/results_fuzz/bytes_changed.py), or their content by HDF5 itself (contents_changed.py): types,
shapes, names, texts, settings, links, storage in other files. A command that reads results then runs on each in a
process with limits of processor time and memory. A fault is a traceback, a warning of Python's, a signal, a hang, exit
code 1, or numbers of a finished file with flipped bits that `info --check` calls sound and that are not those that were
written. (A killed run's file has Fletcher-32 alone, which takes 16 ones for 16 zeros.) The changed file
of each fault is kept. The exit code is 1 where there was one.
"""

from __future__ import annotations

import argparse
import random
import shutil
import sys
from collections import Counter
from pathlib import Path
from time import monotonic

from results_fuzz.bytes_changed import change_bytes
from results_fuzz.contents_changed import change_contents
from results_fuzz.originals import Originals, same_numbers
from results_fuzz.watched import Ending, warm_up, watched

#: What a command may take: processor time in s (that of `verify` is 10 s), memory in bytes.
SECONDS, MEMORY = 30, 2 * 2**30
COMMANDS: dict[str, tuple[str, ...]] = {
    "info": ("info", "R"),
    "info --json": ("info", "R", "--json"),
    "info --check": ("info", "R", "--check"),
    "export": ("export", "R", "-o", "tables"),
    "plot": ("plot", "R", "-o", "pictures", "--kind", "violation", "--kind", "energy"),
    "rerun": ("rerun", "R", "-o", "again.h5", "--quiet"),
    "compare-results": ("compare-results", "R", "whole.h5"),
    "compare-results 2": ("compare-results", "whole.h5", "R"),
    "verify --store": ("verify", "scene.yaml", "--store", "R"),
    "run -o": ("run", "scene.yaml", "-o", "R", "--quiet"),
    "run, part": ("run", "scene.yaml", "-o", "new.h5", "--quiet"),
}
#: How often each is drawn: what takes seconds of its own comes rarely.
WEIGHTS = {"verify --store": 1, "plot": 2, "run -o": 3, "run, part": 3}


class Campaign:
    """What was found so far."""

    def __init__(self, folder: Path, seed: int) -> None:
        self.folder, self.draw = folder, random.Random(seed)
        self.codes: Counter[tuple[str, int]] = Counter()
        self.changes: Counter[str] = Counter()
        self.faults: Counter[str] = Counter()
        self.slowest: dict[str, float] = {}
        self.originals = Originals.made_in(folder / "originals")

    def take(self, number: int) -> None:
        """Changes a file and runs a command on it."""
        original = self.draw.choice(self.originals.paths)
        command = self.draw.choices(list(COMMANDS), [WEIGHTS.get(name, 6) for name in COMMANDS])[0]
        place = self._place(command, original)
        shutil.copyfile(original, place)
        in_bytes = self.draw.random() < 0.5 or original.name.endswith(".part")
        how = (change_bytes if in_bytes else change_contents)(place, self.draw)
        changed = self.folder / "changed.bin"
        shutil.copyfile(place, changed)
        arguments = [place.name if word == "R" else word for word in COMMANDS[command]]
        ending = watched(arguments, place.parent, SECONDS, MEMORY)
        self.codes[command, ending.code] += 1
        self.changes[how.partition(":")[0]] += 1
        self.slowest[command] = max(self.slowest.get(command, 0.0), ending.seconds)
        fault = ending.fault
        if fault == "does not end" and command == "rerun" and "setting" in how:
            fault = None  # it was told to run for long
        whole = not original.name.endswith(".part")
        if fault is None and whole and in_bytes and command == "info --check" and ending.code == 0:
            fault = None if same_numbers(original, changed) else "other numbers pass"
        if fault is not None:
            self._keep(number, fault, command, how, ending, changed)

    def _place(self, command: str, original: Path) -> Path:
        """Where the changed file stands, in a folder with what the command needs."""
        work = self.folder / "work"
        shutil.rmtree(work, ignore_errors=True)
        self.originals.furnish(work)
        is_part = command == "run, part" or original.name.endswith(".part")
        return work / ("new.h5.part" if is_part else "changed.h5")

    def _keep(self, number: int, fault: str, command: str, how: str, ending: Ending, changed: Path) -> None:
        self.faults[f"{fault}, {command}"] += 1
        kept = self.folder / f"{number:05}.h5"
        shutil.copyfile(changed, kept)
        last = ending.said.strip().splitlines()[-1:] or [""]
        print(f"{kept}: {fault}: {command} after {how}", flush=True)
        for line in [line for line in ending.said.splitlines() if "Error" in line or "File" in line][-4:] or last:
            print(f"    {line[:160]}", flush=True)

    def report(self) -> None:
        """The tables."""
        print(f"{sum(self.codes.values())} files, {sum(self.faults.values())} faults")
        for command in COMMANDS:
            codes = {code: count for (name, code), count in sorted(self.codes.items()) if name == command}
            if codes:
                listed = ", ".join(f"{count} ended with {code}" for code, count in codes.items())
                print(f"  {command:18} {listed}; at most {self.slowest[command]:.1f} s of processor time")
        for change, count in self.changes.most_common():
            print(f"  {count:6} {change}")
        for fault, count in self.faults.most_common():
            print(f"  {count:6} times {fault}")


def main() -> None:
    """Runs the campaign."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--minutes", type=float, default=10.0)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--output", type=Path, default=Path("build/results-campaign"), help="where files are kept")
    asked = parser.parse_args()
    folder = asked.output.resolve()
    folder.mkdir(parents=True, exist_ok=True)
    warm_up()
    campaign, end, number = Campaign(folder, asked.seed), monotonic() + 60.0 * asked.minutes, 0
    while monotonic() < end:
        campaign.take(number)
        number += 1
    campaign.report()
    sys.exit(1 if campaign.faults else 0)


if __name__ == "__main__":
    main()
