"""The code is clean under the tools that pyproject.toml and `.clang-format` configure, and tests import and mutate what
is there."""

from __future__ import annotations

import ast
import re
import shutil
import subprocess
import sys

import pytest

from scripts.mutations import Mutation, read_table
from tests.support import ROOT

# The code is clean under the linter, the type checker and the formatters that pyproject.toml and `.clang-format`
# configure.

CLANG_FORMAT = shutil.which("clang-format")
#: Places that the formatter leaves alone: tables that it would spread over a page.
MOST_EXCEPTIONS = 30
#: Words of a sentence in a docstring at most.
LONGEST_SENTENCE = 25


@pytest.mark.parametrize(
    "tool",
    [
        ["ruff", "check"],
        ["ruff", "format", "--check"],
        pytest.param(["mypy"], marks=[pytest.mark.full, pytest.mark.long]),
    ],
    ids=["ruff", "format", "mypy"],
)
def test_clean(tool):
    done = subprocess.run([sys.executable, "-m", *tool], capture_output=True, text=True, cwd=ROOT, check=False)
    assert done.returncode == 0, done.stdout + done.stderr


@pytest.mark.skipif(CLANG_FORMAT is None, reason="needs clang-format")
def test_headers_are_formatted():
    """Versions differ in a line here and there, so that as many lines may be off."""
    off = 0
    for path in sorted((ROOT / "mbproj" / "kernel" / "src").rglob("*.?pp")):
        done = subprocess.run([str(CLANG_FORMAT), str(path)], capture_output=True, text=True, check=True)
        off += len(set(done.stdout.splitlines()) - set(path.read_text(encoding="utf-8").splitlines()))
    assert off <= MOST_EXCEPTIONS


def test_few_places_are_kept_from_the_formatter():
    mark = "# fmt" + ":"
    folders = (ROOT / "mbproj", ROOT / "scripts", ROOT / "tests")
    texts = [path.read_text(encoding="utf-8") for folder in folders for path in folder.rglob("*.py")]
    assert sum(text.count(mark) for text in texts) <= MOST_EXCEPTIONS


def test_tests_import_no_tests_and_skip_nothing_that_they_find_out():
    """What tests share stands in modules of its own. A test is skipped by a mark, for what the machine has: one that
    skips itself where its own numbers do not suit passes when nothing suits any more."""
    for path in sorted((ROOT / "tests").rglob("*.py")):
        text = path.read_text(encoding="utf-8")
        assert not re.search(r"(from|import)\s+tests(\.\w+)*[.\s]+(import\s+)?test_\w+", text), path
        for node in ast.walk(ast.parse(text)):
            if isinstance(node, ast.Call) and isinstance(node.func, ast.Attribute) and node.func.attr == "skip":
                assert not isinstance(node.func.value, ast.Name), f"{path}:{node.lineno}"


def _sentences(text: str) -> list[str]:
    """The sentences of a docstring, without tables, formulas and code, which stand deeper than the text."""
    depth = min((len(line) - len(line.lstrip()) for line in text.splitlines()[1:] if line.strip()), default=0)
    lines = [line if not line.startswith(" " * (depth + 2)) else "" for line in text.splitlines()]
    return re.split(r"(?<=[.:;!?])\s+|\n\s*\n", "\n".join(lines))


def test_sentences_of_docstrings_are_short():
    """Words of two letters or more, and the article: what a formula adds is not counted."""
    word = re.compile(r"[(`']*[A-Za-z'’_-]{2,}[)`'.,:;!?]*|[aAI],?")
    for path in sorted((ROOT / "mbproj").rglob("*.py")):
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if isinstance(node, (ast.Module, ast.ClassDef, ast.FunctionDef)):
                for sentence in _sentences(ast.get_docstring(node, clean=False) or ""):
                    length = sum(word.fullmatch(each) is not None for each in sentence.split())
                    assert length <= LONGEST_SENTENCE, f"{path}: {length} words: {' '.join(sentence.split())}"


# The mutations that measure what the tests catch are of the sources as they are.

TABLE = read_table()


def test_half_of_them_are_in_the_kernel() -> None:
    assert len(TABLE) >= 40
    assert 0.4 <= sum(each.is_compiled for each in TABLE) / len(TABLE) <= 0.6


@pytest.mark.parametrize("mutation", TABLE, ids=lambda each: each.name)
def test_a_mutation_changes_one_place_and_names_tests_that_are_there(mutation: Mutation) -> None:
    """Who changes that place writes the new one into scripts/mutations.yaml."""
    assert (ROOT / mutation.file).read_text().count(mutation.old) == 1
    assert mutation.new != mutation.old
    assert mutation.tests
    assert all((ROOT / test).is_file() for test in mutation.tests)
