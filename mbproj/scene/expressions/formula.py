"""Formulas as functions: an expression whose names stand for numbers and for other functions."""

from __future__ import annotations

from mbproj.functions.program import CHANNELS, Program, number, replaced
from mbproj.functions.standard import combine
from mbproj.scene.expressions.compiled import compiled
from mbproj.scene.expressions.syntax_tree import parse


def formula(text: str, **parts: float | Program) -> Program:
    """The program of the expression `text`; `parts` are the numbers and programs that its names stand for."""
    tree = parse(text, frozenset(parts))
    code, _ = compiled(tree, {}, {name: CHANNELS + at for at, name in enumerate(parts)})
    programs = [part if isinstance(part, Program) else Program(number(part)) for part in parts.values()]
    return combine(lambda *own: replaced(code, {CHANNELS + at: each for at, each in enumerate(own)}), *programs)
