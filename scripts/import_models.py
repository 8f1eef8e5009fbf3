"""Imports every model in folders, runs it for 10 s, and prints a table: what was said, agreement with MuJoCo, how far
joints open, energy, time.

    python scripts/import_models.py FOLDER .. [--duration 10]

Agreement is that of mass matrix, bias forces and accelerations of the tree with MuJoCo's at ten random states, relative
to the largest numbers; "-" where MuJoCo does not read the file. The energy is what its balance lacks, relative to the
largest; the time is the processor's, of `mbproj run` with its start.
"""

from __future__ import annotations

import argparse
import json
import resource
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT))

from tests.formats.agreement import agreement  # noqa: E402

#: "yes", "until then" and "no" are the rows of the import's table by what they say of the motion.
COLUMNS = (
    *("model", "bodies", "joints", "loops", "redundant", "yes", "until then", "no"),
    *("mass matrix", "bias", "accelerations", "open", "energy", "time s"),
)


def mbproj(*arguments: str) -> subprocess.CompletedProcess[str]:
    """`mbproj ARGUMENTS`."""
    command = [sys.executable, "-c", "from mbproj.commands.main import main; main()", *arguments]
    return subprocess.run(command, capture_output=True, text=True, cwd=ROOT, check=False)


def row(path: Path, name: str, folder: Path, duration: float) -> list[str]:
    """A row of the table; the first line of the error where the model cannot be read or run."""
    from mbproj.base.errors import MbprojError
    from mbproj.commands.python.models import import_model
    from mbproj.formats.mechanism import Same

    try:
        found = import_model(path, folder=folder)
    except MbprojError as error:
        return [name, str(error).splitlines()[0].replace(str(path.parent), "")]
    mechanism, scene = found.mechanism, folder / "scene.yaml"
    scene.write_text(found.text, encoding="utf-8")
    said = [str(sum(each.same is same for each in mechanism.said)) for same in Same]
    loops = len(mechanism.joints) - len(mechanism.tree)
    start = [name, str(len(mechanism.parts)), str(len(mechanism.joints)), str(loops)]
    before = resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime
    done = mbproj("run", str(scene), "--duration", str(duration), "-o", str(folder / "r.h5"), "--json", "--quiet")
    took = resource.getrusage(resource.RUSAGE_CHILDREN).ru_utime - before
    if done.returncode:
        why = next((line for line in done.stderr.splitlines() if "error: " in line), "?").replace(str(folder), "")
        return [*start, "", *said, *agreed(path), why]
    facts: dict[str, Any] = json.loads(done.stdout)
    (folder / "r.h5").unlink()
    opened, drift = f"{facts['position_violation_max']:.1e}", f"{facts['energy_drift_relative']:.1e}"
    return [*start, str(facts["redundant_rows"]), *said, *agreed(path), opened, drift, f"{took:.1f}"]


def agreed(path: Path) -> list[str]:
    """The differences from MuJoCo's numbers."""
    try:
        return [f"{each:.0e}" for each in agreement(path)] if path.suffix != ".sdf" else ["-"] * 3
    except Exception:  # MuJoCo raises several
        return ["-"] * 3


def is_model(path: Path) -> bool:
    """Whether it begins as one: packages have other XML files, too."""
    return path.suffix in (".urdf", ".sdf") or (
        path.suffix == ".xml" and "<mujoco" in path.read_text(encoding="utf-8", errors="replace")
    )


def main() -> None:
    """Prints the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("folders", type=Path, nargs="+")
    parser.add_argument("--duration", type=float, default=10.0)
    asked = parser.parse_args()
    print("\t".join(COLUMNS))
    with tempfile.TemporaryDirectory() as folder:
        for top in asked.folders:
            for path in sorted(filter(is_model, (each for each in top.rglob("*") if each.is_file()))):
                name = str(path.relative_to(top))
                print("\t".join(row(path, name, Path(folder), asked.duration)), flush=True)


if __name__ == "__main__":
    main()
