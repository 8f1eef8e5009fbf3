"""Tests go through what packages offer, so that a module that moves moves no tests but those of its own package."""

from __future__ import annotations

import ast
from pathlib import Path

from tests.support import ROOT

#: What tests import from inside of packages that are not theirs, by the reason for which the package does not offer it.
REACHED = {
    "it is called as its module or folder, which the package has by this name": """
        analysis.observed analysis.tables dynamics.fast_modes guide.pages linear.equilibrium linear.modes linear.stored
        scene.expressions.compiled studies.compare.comparison studies.recommend.recommendation
        studies.stability.bisection studies.verify""",
    "its name tells too little away from its module": """
        api.check.fast_forces dynamics.derivatives.tangent figures functions.program functions.series
        integrate.steppers.order_conditions model.euler_parameters scene.blocks.forces.coulomb scene.blocks.oversights
        scene.expressions.syntax_tree scene.fields.rotations""",
    "a test replaces or counts what the module calls": """
        dynamics.equations integrate.formulations integrate.reporting""",
    "it is an entry of a table, which others ask for it": "constraints parts.classes projection.methods",
    "a command, and what it prints, is looked at from the package whose results it shows": "cli",
}


def reached_into(path: Path) -> set[str]:
    """The modules below the first level that a test imports from packages other than the one of its folder."""
    inner_modules = set()
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.ImportFrom) and node.module and node.module.startswith("mbproj."):
            _, package, *inner = node.module.split(".")
            if inner and package not in path.relative_to(ROOT).parts:
                inner_modules.add(node.module.removeprefix("mbproj."))
    return inner_modules


def test_tests_import_what_packages_offer():
    reached = {module for path in (ROOT / "tests").rglob("test_*.py") for module in reached_into(path)}
    allowed = {each for modules in REACHED.values() for each in modules.split()}
    of = {module: {each for each in allowed if f"{module}.".startswith(f"{each}.")} for module in reached}
    assert [module for module in sorted(reached) if not of[module]] == []
    assert allowed == set().union(*of.values())  # the list says no more than is so
