"""A reference's table in the columns that mbproj records, with its origin in the first line."""

from __future__ import annotations

import csv
from collections.abc import Iterable, Mapping
from math import atan2
from pathlib import Path
from typing import Any

from .case import Case
from .scene_text import joint_names

Json = Mapping[str, Any]
#: Digits that are kept: more than any of the references has right, but for what is given at one time only.
DIGITS, ALL_DIGITS = 9, 16


def reference_table(case: Case, mechanism: Json, folder: Path) -> str:
    """The table's text."""
    if "file" in mechanism["reference"]:
        rows, digits = _rows(case, folder / mechanism["reference"]["file"]), DIGITS
    else:
        rows, digits = [_at_one_time(mechanism)], ALL_DIGITS
    body = (",".join([f"{row['t']:.12g}", *(f"{row[it] + 0.0:.{digits}g}" for it in case.columns)]) for row in rows)
    return "\n".join([f"# {case.origin}", ",".join(["t", *case.columns.values()]), *body]) + "\n"


def _rows(case: Case, path: Path) -> Iterable[Mapping[str, float]]:
    """The rows at multiples of the case's grid (solvers add rows at events), and of those every k-th and the last."""
    with path.open(encoding="utf-8", newline="") as file:
        rows = [{name: float(cell) for name, cell in row.items()} for row in csv.DictReader(file)]
    regular = [row for row in rows if abs(row["t"] / case.grid - round(row["t"] / case.grid)) < 1e-6]
    kept = regular[:: case.every]
    return kept if kept[-1] is regular[-1] else [*kept, regular[-1]]


def _at_one_time(mechanism: Json) -> Mapping[str, float]:
    """Andrews' squeezer: the angle of each body is a sum of the source's coordinates; a joint's angle is counted from
    the start."""
    given = mechanism["reference"]
    sums = dict(item.split("=") for item in given["body_angles"].split(","))
    row: dict[str, float] = {"t": given["t"]}
    turned = {"ground": 0.0}
    for body in mechanism["bodies"]:
        name = body["name"]
        for quantity, key in (("angle", "q"), ("speed", "qdot"), ("acceleration", "qddot")):
            of = dict(zip(given["names"], given[key], strict=True))
            row[f"{name}.{quantity}"] = sum(of[term] for term in sums[name].split("+"))
        turned[name] = row[f"{name}.angle"] - 2.0 * atan2(body["q"][3], body["q"][0])
    for joint in joint_names(mechanism).values():
        row[f"{joint['body2']}.{joint['body1']}"] = turned[joint["body2"]] - turned[joint["body1"]]
    return row
