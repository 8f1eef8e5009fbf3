"""Nothing that a user can type ends in a fault of mbproj: random command lines, scenes, environments and results files.

    python scripts/fuzz_campaign.py [--minutes 15] [--seed 0] [--output build/fuzz]

Each trial is a command line in a folder of scenes, results, pipes, links and other people's files: options with values
that belong there or do not (scripts/fuzz/values.py), a scene with something else in the place of a number, a word or a
line, variables of the environment, stdout closed or full, a results file that is damaged or holds nonsense
(scripts/fuzz/results.py). With --only results all trials are of this last kind. What ends with an exit code other than
0, 2, 3, 4 and 130, hangs, shows a traceback, a warning or a control character, or touches what is not ours is told,
once for each place in the code, and kept in the folder. The exit code is 1 where something was found."""

from __future__ import annotations

import argparse
import os
import re
import shutil
import signal
import sys
from collections import Counter
from contextlib import suppress
from pathlib import Path
from random import Random
from tempfile import TemporaryDirectory
from time import monotonic

import h5py  # noqa: F401  # here, so that no trial has to
import numpy  # noqa: F401
from fuzz.commands import command_line
from fuzz.results import damaged, make_originals, wrong_numbers
from fuzz.scenes import changed
from fuzz.surroundings import environment, furnish, untouched
from fuzz.trial import Ending, trial

import mbproj.show.figures.style
import mbproj.studies.verify.checks  # noqa: F401

MECHANISMS = Path(__file__).resolve().parent.parent / "mechanisms"
#: Scenes to change: small ones.
SCENES = ("five_bar", "inline_four", "spherical_pendulum", "planar_four_bar", "hooke_shaft", "locomotive")
PLACE = re.compile(rb'File "[^"]*/(mbproj/[^"]+)", line (\d+)')


class Campaign:
    """What was done and found so far."""

    def __init__(self, folder: Path, random: Random, only: str | None) -> None:
        self.folder, self.random, self.only = folder, random, only
        self.trials: Counter[str] = Counter()
        self.codes: Counter[str] = Counter()
        self.found: Counter[str] = Counter()

    def step(self, place: Path, model: Path) -> None:
        """One trial in a new folder."""
        folder = place / f"t{self.trials.total()}"
        folder.mkdir()
        furnish(folder, model)
        random, kind = self.random, self.random.random()
        scene, variables, encoding, stdout, how = None, dict[str, str](), "utf-8", None, ""
        if kind > 0.8 or self.only == "results":
            arguments, how = damaged(folder, random)
        elif kind < 0.4:
            scene = "changed.yaml"
            text = changed(random.choice(list(model.glob("scene*.yaml"))).read_text(encoding="utf-8"), random)
            (folder / scene).write_text(text, encoding="utf-8", errors="surrogatepass")
        elif kind < 0.6:
            variables = environment(random)
            encoding = variables.get("PYTHONIOENCODING", "utf-8").partition(":")[0]
        elif kind < 0.65:
            stdout = random.choice(("closed", "/dev/full"))
        what = (
            "results"
            if how
            else "scenes"
            if scene
            else "environments"
            if variables
            else "streams"
            if stdout
            else "options"
        )
        if not how:
            arguments = command_line(random, scene)
        ending = trial([argument.replace("\0", "") for argument in arguments], folder, encoding, stdout, variables)
        self.trials[what] += 1
        self.codes["interrupted" if ending.interrupted else str(ending.code)] += 1
        wrong = ending.wrong or ("" if "--force" in arguments else ", ".join(untouched(folder)))
        wrong = wrong or (wrong_numbers(folder, arguments, how, ending) if how else "")
        if wrong:
            self._tell(wrong, arguments, variables, stdout or how or None, folder, ending)
        shutil.rmtree(folder)
        folder.with_suffix(".log").unlink()

    def _tell(
        self,
        wrong: str,
        arguments: list[str],
        variables: dict[str, str],
        stdout: str | None,
        folder: Path,
        ending: Ending,
    ) -> None:
        places = PLACE.findall(ending.printed)
        at = f"{places[-1][0].decode()}:{places[-1][1].decode()}" if places else ending.printed[-60:].decode("latin-1")
        self.found[f"{wrong} at {at!r}"] += 1
        if self.found[f"{wrong} at {at!r}"] > 1:
            return
        kept = self.folder / f"{self.trials.total():05}"
        shutil.rmtree(kept, ignore_errors=True)
        kept.mkdir(parents=True)
        (kept / "printed").write_bytes(ending.printed)
        (kept / "arguments").write_text(f"{arguments!r}\n{variables!r}\n{stdout!r}\n", encoding="utf-8")
        for name in ("changed.yaml", "changed.bin"):
            if (folder / name).exists():
                shutil.copyfile(folder / name, kept / name)
        print(f"{kept}: {wrong}: {[argument[:60] for argument in arguments]} {variables} {stdout or ''}", flush=True)
        lines = ending.printed.decode("utf-8", "backslashreplace").splitlines()
        print(ascii("\n".join(line for line in lines[-3:] if not line.startswith("error: this is")))[:400], flush=True)

    def report(self) -> str:
        """The counts."""

        def table(counts: Counter[str]) -> str:
            return ", ".join(f"{count} {name}" for name, count in sorted(counts.items()))

        found = "\n".join(f"  {count} times {name}" for name, count in self.found.most_common())
        return (
            f"{self.trials.total()} trials ({table(self.trials)})\nexit codes: "
            f"{', '.join(f'{name}: {count}' for name, count in sorted(self.codes.items()))}\n"
            f"{len(self.found)} different findings\n{found}".rstrip()
        )


def model_folder(place: Path) -> Path:
    """Scenes that run at once, and results of one."""
    model = place / "model"
    model.mkdir()
    for number, name in enumerate(SCENES):
        if (MECHANISMS / f"{name}.yaml").exists():
            shutil.copyfile(MECHANISMS / f"{name}.yaml", model / f"scene{number or ''}.yaml")
    shutil.copyfile(MECHANISMS / "spatial_slider_crank.yaml", model / "spatial.yaml")
    for output in ("short.h5", "other.h5"):
        ending = trial(["run", "scene.yaml", "--duration", "0.05", "-o", output], model, "utf-8", None, {})
        assert ending.code == 0, ending.printed
    make_originals(model)
    return model


def main() -> None:
    """Runs trials until the time is up."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--minutes", type=float, default=15.0)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--output", type=Path, default=Path("build/fuzz"))
    parser.add_argument("--only", choices=["results"])
    options = parser.parse_args()
    with TemporaryDirectory(prefix="mbproj-fuzz-") as place:
        os.environ["MBPROJ_CACHE"] = f"{place}/cache"
        campaign = Campaign(options.output.resolve(), Random(options.seed), options.only)
        model = model_folder(Path(place))
        until = monotonic() + 60.0 * options.minutes
        signal.signal(signal.SIGTERM, signal.default_int_handler)
        with suppress(KeyboardInterrupt):  # what was done until then counts
            while monotonic() < until:
                campaign.step(Path(place), model)
    print(campaign.report())
    sys.exit(1 if campaign.found else 0)


if __name__ == "__main__":
    main()
