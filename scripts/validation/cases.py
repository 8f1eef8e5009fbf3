"""Every validation case by name."""

from __future__ import annotations

from collections.abc import Mapping

from .adams import ADAMS
from .case import Case
from .dymola import DYMOLA
from .others import OTHERS

CASES: Mapping[str, Case] = {case.name: case for case in (*ADAMS, *DYMOLA, *OTHERS)}
