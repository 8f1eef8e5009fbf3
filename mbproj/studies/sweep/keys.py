"""What a case is known by: a hash of all that its numbers follow from."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Sequence

from mbproj.kernel import build_info
from mbproj.plugins import marks
from mbproj.scene.ranges import Item
from mbproj.scene.records import Expectation
from mbproj.version import __version__

#: Bytes of a key: among 1e9 cases no two agree by chance.
SIZE = 16


class Keys:
    """The keys of cases of a scene's text in which these paths vary; mbproj's version and build are part of them."""

    def __init__(self, text: str, paths: Sequence[str]) -> None:
        common = json.dumps([__version__, build_info(), text, *marks()])
        self._common = hashlib.blake2b(common.encode(), digest_size=SIZE)
        self._paths = tuple(paths)

    def of(self, values: Sequence[Item]) -> str:
        """The key of the case with these values, in hexadecimal digits; the order of the paths has no part in it."""
        found = self._common.copy()
        found.update(json.dumps(sorted(zip(self._paths, values, strict=True))).encode())
        return found.hexdigest()


def identity(measure: Expectation) -> str:
    """What a measure is known by, whatever it is called: what it is of and what it takes of that."""
    further = [measure.over, *measure.between] if measure.over or measure.between else []
    return json.dumps([measure.of, measure.item, measure.quantity, measure.component, measure.at, *further])
