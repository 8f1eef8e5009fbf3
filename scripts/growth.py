"""How the cost of each command grows with the number of bodies: processor time, memory, and the exponent between sizes.

    python scripts/growth.py [--only chain grid ...] [--sizes small|all] [--json FILE] [--figure FILE]

Commands run one by one, each in a process of its own. The system counts its processor time and its largest memory; the
time of a command without work is taken off. Phases are timed in one process more: reading, compiling, assembly, the
planar test, the count of redundant rows, a sample with its reactions. The last column gives the exponent p of
time ~ bodies^p between the two largest sizes. Scenes are those of scripts/large_mechanisms.
"""

from __future__ import annotations

import argparse
import json
import math
import os
import subprocess
import sys
import tempfile
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

from large_mechanisms.phases import PHASES
from large_mechanisms.scenes import FAMILIES

#: Sizes by family: about 150, 450, 1000 and 2500 bodies.
SIZES = {
    "chain": (150, 450, 1000, 2500),
    "ladder": (50, 150, 333, 833),
    "grid": (4, 8, 12, 20),
    "four_bars": (75, 225, 500, 1250),
    "walker": (12, 35, 77, 192),
}
COMMANDS: dict[str, Callable[[str, str], list[str]]] = {
    "check": lambda scene, results: ["check", scene],
    "run": lambda scene, results: ["run", scene, "-o", results],
    "plot": lambda scene, results: ["plot", results, "-o", f"{results}-pictures"],
    "animate": lambda scene, results: ["animate", results, "-o", f"{results}.html"],
    "modes": lambda scene, results: ["modes", scene],
}
#: A command is not tried at sizes above one at which it took so many seconds.
MOST_SECONDS = 120.0
Row = dict[str, Any]


def main() -> None:
    """Prints the tables."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--only", nargs="+", default=list(FAMILIES), choices=list(FAMILIES), metavar="FAMILY")
    parser.add_argument("--sizes", default="all", choices=["small", "all"], help="small: the two smallest")
    parser.add_argument("--json", type=Path, help="write all numbers here")
    parser.add_argument("--figure", type=Path, help="draw them here")
    options = parser.parse_args()
    rows = []
    with tempfile.TemporaryDirectory() as folder:
        idle, _ = _measured(["--version"], folder)
        for family in options.only:
            sizes = SIZES[family][:2] if options.sizes == "small" else SIZES[family]
            rows += list(_family(family, sizes, folder, idle))
            print(_table(family, rows), flush=True)
    if options.json:
        options.json.write_text(json.dumps(rows, indent=1), encoding="utf-8")
    if options.figure:
        draw(rows, options.figure)


def _family(family: str, sizes: tuple[int, ...], folder: str, idle: float) -> Iterator[Row]:
    given_up = set()
    for size in sizes:
        text = FAMILIES[family](size)
        scene, results = f"{folder}/{family}_{size}.yaml", f"{folder}/{family}_{size}.h5"
        Path(scene).write_text(text, encoding="utf-8")
        bodies = sum(line.startswith("  ") and "mass:" in line for line in text.splitlines())
        for name, command in COMMANDS.items():
            if name in given_up:
                continue
            seconds, memory = _measured(command(scene, results), folder)
            if seconds > MOST_SECONDS or math.isnan(seconds):
                given_up.add(name)
            cost = max(seconds - idle, 0.001)
            yield {"family": family, "bodies": bodies, "what": name, "seconds": cost, "memory": memory}
        found = subprocess.run([sys.executable, "-m", "large_mechanisms.phases", scene], **_quietly(folder))
        for name, seconds in zip(PHASES, found.stdout.split(), strict=False):
            yield {"family": family, "bodies": bodies, "what": f"- {name}", "seconds": float(seconds), "memory": None}


def _measured(arguments: list[str], folder: str) -> tuple[float, float]:
    """Processor time in s and largest memory in MB of a command; not a number where it fails."""
    process = subprocess.Popen(
        [sys.executable, "-m", "mbproj", *arguments],
        cwd=folder,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
        env=_environment(),
    )
    _, status, used = os.wait4(process.pid, 0)
    process.returncode = os.waitstatus_to_exitcode(status)
    seconds = used.ru_utime + used.ru_stime if process.returncode == 0 else math.nan
    return seconds, used.ru_maxrss / 1024.0


def _quietly(folder: str) -> dict[str, Any]:
    return {"cwd": folder, "capture_output": True, "text": True, "env": _environment()}


def _environment() -> dict[str, str]:
    """One thread, so that processor time is that of the work; and the scripts of this folder."""
    one = dict.fromkeys(("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS"), "1")
    here = Path(__file__).parent
    return {**os.environ, **one, "PYTHONPATH": f"{here}{os.pathsep}{here.parent}"}


def _table(family: str, rows: list[Row]) -> str:
    """The costs of a family: a line for each command or phase, a column for each size."""
    mine = [row for row in rows if row["family"] == family]
    bodies = sorted({row["bodies"] for row in mine})
    lines = [f"| {family}, s (MB) | {' | '.join(map(str, bodies))} | exponent |", "|---" * (len(bodies) + 2) + "|"]
    for what in dict.fromkeys(row["what"] for row in mine):
        by_size = {row["bodies"]: row for row in mine if row["what"] == what}
        cells = [_cell(by_size.get(size)) for size in bodies]
        lines.append(f"| {what} | {' | '.join(cells)} | {_exponent(by_size)} |")
    return "\n".join(lines) + "\n"


def _cell(row: Row | None) -> str:
    if row is None or math.isnan(row["seconds"]):
        return "-"
    memory = "" if row["memory"] is None else f" ({row['memory']:.0f})"
    return f"{row['seconds']:.2g}{memory}"


def _exponent(by_size: dict[int, Row]) -> str:
    told = [(size, row["seconds"]) for size, row in sorted(by_size.items()) if not math.isnan(row["seconds"])]
    if len(told) < 2:
        return "-"
    (small, before), (large, after) = told[-2:]
    return f"{math.log(after / before) / math.log(large / small):.2f}"


def draw(rows: list[Row], path: Path) -> None:
    """Times of the commands over the number of bodies, a panel for each family, with lines of exponents 1 and 1.3."""
    import matplotlib

    matplotlib.use("Agg")
    from matplotlib import pyplot
    from matplotlib.ticker import LogLocator, NullFormatter

    families = list(dict.fromkeys(row["family"] for row in rows))
    figure, panels = pyplot.subplots(
        1, len(families), figsize=(3.0 * len(families), 3.4), sharex=True, sharey=True, squeeze=False
    )
    for panel, family in zip(panels[0], families, strict=True):
        for name, marker in zip(COMMANDS, "osD^v", strict=True):
            mine = [row for row in rows if row["family"] == family and row["what"] == name]
            bodies, seconds = [row["bodies"] for row in mine], [row["seconds"] for row in mine]
            panel.loglog(bodies, seconds, f"{marker}-", ms=4, lw=1.3, label=name)
        sizes = sorted({row["bodies"] for row in rows if row["family"] == family})
        for power, style in ((1.0, ":"), (1.3, "--")):
            line = [0.06 * (size / sizes[0]) ** power for size in sizes]
            panel.loglog(sizes, line, style, color="0.55", lw=1, label=f"bodies$^{{{power:g}}}$")
        panel.set_title(f"{family.replace('_', ' ')}s", fontsize=10)
        panel.set_xlabel("bodies")
        panel.set_xticks([200, 500, 1000, 2000], ["200", "500", "1000", "2000"])
        panel.xaxis.set_minor_formatter(NullFormatter())
        panel.yaxis.set_major_locator(LogLocator(numticks=9))
        panel.grid(visible=True, which="major", color="0.9", lw=0.6)
        panel.spines[["top", "right"]].set_visible(False)
        panel.tick_params(labelsize=8)
    panels[0][0].set_ylabel("processor time of the command, s")
    handles, labels = panels[0][0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="lower center", ncol=len(labels), fontsize=8, frameon=False)
    figure.tight_layout(rect=(0.0, 0.07, 1.0, 1.0))
    figure.savefig(path, dpi=150)


if __name__ == "__main__":
    main()
