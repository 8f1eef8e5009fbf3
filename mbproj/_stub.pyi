"""The public names, for editors and type checkers: those of `HOMES`."""

from collections.abc import Mapping

from mbproj.scene.parts import *

HOMES: Mapping[str, str]
