"""mbproj and other programs, side by side: the time to stay below an error on the paper's mechanisms; chains, per step.

    python scripts/bench_peers.py [--mechanism NAME] [--peer FILE] [--errors 1e-3 ...] [--repeat 5] [--json FILE]

Needs the extra `peers`; a program that is not installed is left out with a line that says so. One thread; medians of
interleaved repetitions; only integration is timed. Each program sweeps its own step or tolerance (scripts/peers), its
error is measured against tests/data in a separate run, and for each error asked for the table has the cheapest setting
whose measured error is below it: a dash where none is. A coarse setting may be below an error by luck, in all alike.
"""

from __future__ import annotations

import argparse
import json
import math
import sys
from importlib import import_module
from pathlib import Path
from typing import Any

from peers.peer import NotConverged, Peer
from peers.problem import CHAIN_STEPS, MECHANISMS, Array, Chain, Mechanism
from peers.sweep import Trial, candidates, cheapest, interleave, sweep, warm

#: The files of scripts/peers, and what each needs that mbproj does not.
PROGRAMS = {
    "mbproj_run": "",
    "mujoco_rk4": "mujoco",
    "pinocchio_python": "pin",
    "pinocchio_compiled": "pin, cmeel-eigen, c++",
    "exudyn_solvers": "exudyn",
    "simbody_tree": "opensim",
    "hand_derived": "c++",
}
#: What --quick asks for.
QUICK_ERRORS, QUICK_LINKS = (1e-3, 1e-5), (5, 20)
ROWS = list[dict[str, Any]]


def installed(wanted: list[str], formulation: str) -> list[Peer]:
    """The peers of the wanted programs that are here; those that are missing are named."""
    found: list[Peer] = []
    for module in wanted:
        try:
            program = import_module(f"peers.{module}")
        except ImportError as error:
            print(f"left out: {module} ({error}; it needs {PROGRAMS[module]})", file=sys.stderr)
            continue
        found += program.peers(formulation) if module == "mbproj_run" else program.PEERS
    return found


def compare(mechanism: Mechanism, peers: list[Peer], errors: tuple[float, ...], repeat: int, longest: float) -> ROWS:
    """A row for each peer: ms per simulated second and setting for each error."""
    by_peer: dict[str, list[Trial]] = {}
    for peer in peers:
        print(f"sweeping {peer.name} on {mechanism.name} ...", file=sys.stderr, flush=True)
        trials = sweep(peer, mechanism, errors, longest)
        if trials:
            best = min(trials, key=lambda trial: trial.error)
            print(f"  smallest error {best.error:.1e} m at {best.setting.label}", file=sys.stderr, flush=True)
            by_peer[peer.name] = candidates(trials, errors)
    interleave([trial for trials in by_peer.values() for trial in trials], repeat)
    return [
        {"peer": name, "cells": {f"{error:.0e}": _cell(cheapest(trials, error), mechanism) for error in errors}}
        for name, trials in by_peer.items()
    ]


def _cell(trial: Trial | None, mechanism: Mechanism) -> dict[str, Any] | None:
    if trial is None:
        return None
    return {
        "ms_per_second": 1e3 * trial.time / mechanism.duration,
        "setting": trial.setting.label,
        "error": trial.error,
        "opening": trial.opening,
        "all_ms_per_second": [1e3 * each / mechanism.duration for each in trial.seconds],
    }


def print_mechanism(mechanism: Mechanism, errors: tuple[float, ...], rows: ROWS) -> None:
    """The table as Markdown, and the settings behind it."""
    heads = " | ".join(f"≤ {error:.0e} m" for error in errors)
    print(f"\n{mechanism.title}: ms per second of simulated motion\n")
    print(f"| | {heads} | open by, m |\n|---|{'---|' * (len(errors) + 1)}")
    for row in rows:
        cells = [row["cells"][f"{error:.0e}"] for error in errors]
        times = " | ".join("-" if cell is None else f"{cell['ms_per_second']:.2g}" for cell in cells)
        openings = [cell["opening"] for cell in cells if cell is not None and cell["opening"] is not None]
        extent = f"{min(openings):.0e} to {max(openings):.0e}" if openings else "(tree)" if any(cells) else "-"
        print(f"| {row['peer']} | {times} | {extent} |")
    print("\nSettings:")
    for row in rows:
        print(f"- {row['peer']}: " + "; ".join(cell["setting"] if cell else "-" for cell in row["cells"].values()))


def compare_chains(peers: list[Peer], links: tuple[int, ...], repeat: int) -> ROWS:
    """A row for each peer: µs per step and the tip's distance from the exact one, for each number of links."""
    rows: dict[str, dict[str, Any]] = {peer.name: {"peer": peer.name, "cells": {}} for peer in peers if peer.chain}
    for count in links:
        chain = Chain(count)
        trials = []
        for peer in peers:
            setting = peer.chain(chain) if peer.chain else None
            if setting is None:
                continue
            try:
                pilot, seen = warm(setting)
            except NotConverged as error:
                print(f"left out: {peer.name}, {count} links ({error})", file=sys.stderr)
                continue
            trials.append(Trial(peer, setting, _tip_error(chain, seen.points), seen.opening, pilot))
        interleave(trials, repeat)
        for trial in trials:
            rows[trial.peer.name]["cells"][str(count)] = {
                "us_per_step": 1e6 * trial.time / chain.steps,
                "error": trial.error,
                "opening": trial.opening,
                "setting": trial.setting.label,
            }
    return list(rows.values())


def _tip_error(chain: Chain, tip: Array) -> float:
    """Of the tip at the end, m; NaN without a compiler."""
    try:
        exact = import_module("peers.hand_derived").chain_tip(chain)
    except ImportError:
        return float("nan")
    return math.dist(tip.ravel(), exact)


def print_chains(links: tuple[int, ...], rows: ROWS) -> None:
    """The table as Markdown."""
    print("\nPlanar chains of 1 m links, level from rest: µs per step (tip off after the steps, m)\n")
    print("| | " + " | ".join(f"{n} links" for n in links) + f" |\n|---|{'---|' * len(links)}")
    print("| steps of | " + " | ".join(f"{1e3 * Chain(n).step:.2g} ms × {Chain(n).steps}" for n in links) + " |")
    for row in rows:
        cells = [row["cells"].get(str(n)) for n in links]
        values = ("-" if cell is None else f"{cell['us_per_step']:.3g} ({cell['error']:.0e})" for cell in cells)
        print(f"| {row['peer']} | {' | '.join(values)} |")


def main() -> None:
    """Runs what is asked for, prints the tables, writes the JSON."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--mechanism", choices=[*MECHANISMS, "chain"], action="append", help="default: all")
    parser.add_argument("--peer", choices=[*PROGRAMS], action="append", help="default: all")
    parser.add_argument("--errors", type=float, nargs="+", help="in m; default: those of each mechanism")
    parser.add_argument("--links", type=int, nargs="+", default=list(CHAIN_STEPS), help="of the chains")
    parser.add_argument("--formulation", default="auto", help="of mbproj")
    parser.add_argument("--repeat", type=int, default=5, help="repetitions; at least 5 for numbers to publish")
    parser.add_argument("--longest", type=float, default=20.0, help="a sweep ends after a run of so many seconds")
    parser.add_argument("--quick", action="store_true", help="errors to 1e-5 m, chains to 20 links, 2 repetitions")
    parser.add_argument("--json", type=Path, metavar="FILE")
    asked = parser.parse_args()
    repeat = 2 if asked.quick else asked.repeat
    peers, tables = installed(asked.peer or [*PROGRAMS], asked.formulation), {}
    for name in asked.mechanism or [*MECHANISMS, "chain"]:
        if name == "chain":
            links = QUICK_LINKS if asked.quick else tuple(asked.links)
            tables[name] = compare_chains(peers, links, repeat)
            print_chains(links, tables[name])
            continue
        mechanism = MECHANISMS[name]
        errors = tuple(asked.errors or (QUICK_ERRORS if asked.quick else mechanism.errors))
        tables[name] = compare(mechanism, peers, errors, repeat, asked.longest)
        print_mechanism(mechanism, errors, tables[name])
    if asked.json:
        asked.json.write_text(json.dumps(tables, indent=1), encoding="utf-8")


if __name__ == "__main__":
    main()
