"""Writes mbproj/parts/__init__.pyi, which tells editors and type checkers what the classes of a scene's parts take.

python scripts/write_parts.py [--check]      (exit code 1: it is not what the tables say)
"""

from __future__ import annotations

import sys
from collections.abc import Iterator
from pathlib import Path

from mbproj.scene.parts import CLASSES, ScenePart

STUB = Path(__file__).parent.parent / "mbproj" / "parts" / "__init__.pyi"
HEAD = '''"""Written by scripts/write_parts.py from the tables that read a scene."""

from collections.abc import Mapping, Sequence
from typing import Any, SupportsFloat, TypeAlias

import numpy.typing as npt

from mbproj.parts.classes import ScenePart

#: A number in SI units, or text with a unit or an expression.
Quantity: TypeAlias = SupportsFloat | str
Vector: TypeAlias = Sequence[Quantity] | npt.NDArray[Any]
'''


def text() -> str:
    """The stub."""
    classes = "".join(f"\n{line}" for made in CLASSES.values() for line in _class(made))
    return f"{HEAD}{classes}"


def _class(made: type[ScenePart]) -> Iterator[str]:
    first, *lines = (made.__doc__ or "").splitlines()
    yield f"class {made.__name__}(ScenePart):"
    yield f'    """{first}'
    yield from (f"    {line}".rstrip() for line in lines)
    yield '    """'
    yield ""
    yield "    def __init__("
    yield "        self,"
    yield "        *,"
    for each in made.__signature__.parameters.values():  # type: ignore[attr-defined]
        yield f"        {each.name}: {each.annotation}{'' if each.default is each.empty else ' = ...'},"
    yield "    ) -> None: ..."
    yield ""


def main() -> int:
    """Writes it, or compares."""
    found = text()
    if sys.argv[1:] == ["--check"]:
        return int(not STUB.is_file() or STUB.read_text(encoding="utf-8") != found)
    STUB.write_text(found, encoding="utf-8")
    print(STUB)
    return 0


if __name__ == "__main__":
    sys.exit(main())
