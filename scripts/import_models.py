"""Imports every model in a folder, runs it for 10 s, and prints a table: what was said, agreement with MuJoCo, how far
joints open, time.

    python scripts/import_models.py FOLDER [--duration 10]

Agreement is that of mass matrix and accelerations of the tree with MuJoCo's at ten random states, relative to the
largest number; "-" where MuJoCo does not read the file as it stands.
"""

from __future__ import annotations

import argparse
import json
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT))

from tests.formats.agreement import agreement  # noqa: E402

COLUMNS = (
    "model",
    "bodies",
    "joints",
    "loops",
    "redundant",
    "said",
    "not same",
    "agreement",
    "open",
    "drift",
    "time s",
)


def mbproj(*arguments: str) -> subprocess.CompletedProcess[str]:
    """`mbproj ARGUMENTS`."""
    command = [sys.executable, "-c", "from mbproj.cli import main; main()", *arguments]
    return subprocess.run(command, capture_output=True, text=True, cwd=ROOT, check=False)


def row(path: Path, folder: Path, duration: float) -> list[str]:
    """A row of the table; the first line of the error where the model cannot be read or run."""
    from mbproj.errors import MbprojError
    from mbproj.formats import read_model, scene_text
    from mbproj.formats.mechanism import Same

    name = f"{path.parent.name}/{path.name}"
    try:
        mechanism = read_model(path)
    except MbprojError as error:
        return [name, str(error).splitlines()[0].replace(str(path.parent), "")]
    scene = folder / "scene.yaml"
    scene.write_text(scene_text(mechanism, "script"), encoding="utf-8")
    said = str(len(mechanism.said))
    wrong = str(sum(each.same is Same.NO for each in mechanism.said))
    loops = len(mechanism.joints) - len(mechanism.tree)
    start = [name, str(len(mechanism.parts)), str(len(mechanism.joints)), str(loops)]
    begun = time.perf_counter()
    done = mbproj("run", str(scene), "--duration", str(duration), "-o", str(folder / "r.h5"), "--json", "--quiet")
    took = time.perf_counter() - begun
    if done.returncode:
        why = next((line for line in done.stderr.splitlines() if "error: " in line), "?").replace(str(folder), "")
        return [*start, "", said, wrong, agreed(path), why]
    facts: dict[str, Any] = json.loads(done.stdout)
    (folder / "r.h5").unlink()
    opened, drift = f"{facts['position_violation_max']:.1e}", f"{facts['energy_drift_relative']:.1e}"
    return [*start, str(facts["redundant_rows"]), said, wrong, agreed(path), opened, drift, f"{took:.1f}"]


def agreed(path: Path) -> str:
    """The larger of the two differences from MuJoCo's numbers."""
    try:
        return f"{max(agreement(path)):.0e}" if path.suffix == ".xml" else "-"
    except Exception as error:
        return f"- ({type(error).__name__})"


def main() -> None:
    """Prints the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("folder", type=Path)
    parser.add_argument("--duration", type=float, default=10.0)
    asked = parser.parse_args()
    print("\t".join(COLUMNS))
    with tempfile.TemporaryDirectory() as folder:
        for path in sorted(asked.folder.rglob("*")):
            if path.suffix in (".xml", ".urdf", ".sdf"):
                print("\t".join(row(path, Path(folder), asked.duration)), flush=True)


if __name__ == "__main__":
    main()
