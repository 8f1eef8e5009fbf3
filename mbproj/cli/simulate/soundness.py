"""The check of a results file or of a sweep's folder, as lines and for JSON (`info --check`)."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import asdict
from pathlib import Path
from typing import Any

from mbproj.errors import shortened
from mbproj.results import Results, Soundness


def of_sweep(folder: Path) -> tuple[dict[str, Any], list[str]]:
    """The result of checking a sweep's folder, as a dictionary for JSON and as lines."""
    from mbproj.studies.sweep.check import check_sweep

    soundness = check_sweep(folder)
    lines = [f"{folder}: {soundness.rows} rows and {soundness.files} results files read"]
    lines += [f"  wrong: {fault}" for fault in soundness.faults] or ["  nothing is wrong with it"]
    lines += [f"  {name} has no checksums: an older mbproj wrote it" for name in soundness.unguarded]
    lines += [
        f"  delete '{folder / name}': a sweep keeps the results files that it finds" for name in soundness.damaged
    ]
    lines += ["  start the sweep again: it computes what is damaged or missing"] if soundness.faults else []
    return {"folder": str(folder), "sound": not soundness.faults, **asdict(soundness)}, lines


def facts(results: Results, soundness: Soundness) -> dict[str, Any]:
    """The result of checking a results file, as a dictionary for JSON."""
    return {"file": str(results.path), "sound": not soundness.faults, **asdict(soundness)}


def lines(results: Results, soundness: Soundness) -> Iterator[str]:
    """Yield the result of checking a results file, line by line."""
    yield f"{results.path}: {soundness.datasets} datasets read, {soundness.bytes / 1e6:.3g} MB of samples"
    yield from (f"  wrong: {fault}" for fault in soundness.faults)
    if not soundness.faults:
        yield "  nothing is wrong with it"
    if len(soundness.unguarded) == soundness.datasets:
        yield "  it has no checksums: an older mbproj wrote it, and changed numbers would not show"
    elif soundness.unguarded:
        yield f"  {len(soundness.unguarded)} datasets have no checksum: {shortened(soundness.unguarded, 8)}"
    if results.contents.unfinished:
        yield "  its run has not ended: samples have Fletcher-32 alone, which takes 16 ones for 16 zeros"
