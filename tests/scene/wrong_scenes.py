"""What is wrong with a scene, by the rows of `wrong/*.yaml`: one piece of the good scene, what stands there instead,
and the first message (behind the file's name). `schema: blind` marks what a JSON Schema cannot see."""

from __future__ import annotations

from pathlib import Path

import yaml

from mbproj.joints.table import JOINTS

#: What the table of joints has, as messages list it.
JOINT_TYPES = " or ".join([", ".join([*JOINTS][:-1]), [*JOINTS][-1]])
TABLE: dict[str, list[dict[str, str]]] = {
    path.stem: yaml.load(path.read_text(encoding="utf-8"), Loader=getattr(yaml, "CBaseLoader", yaml.BaseLoader))
    for path in sorted((Path(__file__).parent / "wrong").glob("*.yaml"))
}
WRONG: dict[str, list[tuple[str, str, str]]] = {
    group: [(row["old"], row["new"], f"f.yaml:{row['message']}".replace("<joints>", JOINT_TYPES)) for row in rows]
    for group, rows in TABLE.items()
}
ROWS = [row for rows in WRONG.values() for row in rows]
IDS = [f"{group}-{number}" for group, rows in WRONG.items() for number, _ in enumerate(rows)]
#: Those that a JSON Schema of the format accepts nevertheless.
BLIND = {
    f"{group}-{number}"
    for group, rows in TABLE.items()
    for number, row in enumerate(rows)
    if row.get("schema") == "blind"
}
