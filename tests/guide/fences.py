"""The fenced blocks of a page of the guide, and running them in the order in which a reader meets them.

- ```` ```yaml NAME.yaml ````: saved as NAME.yaml; it has to be read as a scene, or as a sweep or a design where it is
  one.
- ```` ```yaml ````: a part of a scene; with the last scene saved before, or a pendulum, it has to be read.
- ```` ```console ````: lines that begin with `$ ` are commands; what follows is what they print, where `...` stands
  for what is left out. Numbers may differ. `exit N` after the language: the exit code of the last command, 0 otherwise.
- ```` ```xml NAME.xml ````, `text NAME`: a model of another program, or another file, saved so.
- ```` ```python ````: a program.
- ```` ```python FILE ````, `json FILE`, `cpp FILE`: a file of mbproj, or lines of one; test_contributing.py adds them.
- `slow` after the language: run by scripts/run_guide.py alone. ```` ```text ````: not run.
"""

from __future__ import annotations

import re
import shlex
import shutil
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import yaml

from mbproj.guide.pages import GuidePage
from mbproj.scene.scene import read_scene
from mbproj.studies.design import spec as designs
from mbproj.studies.sweep import spec as sweeps
from mbproj.studies.synthesis.spec import is_synthesis, read_wanted
from tests.cli.commands import mbproj, python
from tests.support import ROOT

LANGUAGES = ("yaml", "console", "python", "text", "sh", "xml", "json", "cpp")
PENDULUM = """
mbproj: 1
gravity: [0, 0, -9.81]
simulation: {duration: 1 s, step: 1 ms}
bodies:
  bob: {mass: 1, inertia: [0.01, 0.01, 0.01], position: [0, 0, -1]}
joints:
  pin: {type: revolute, bodies: [ground, bob], location: [0, 0, 0], axis: [0, 1, 0]}
"""


@dataclass(frozen=True)
class Fence:
    """A fenced block: its language, the words after that, its text, the line that it begins at."""

    language: str
    words: tuple[str, ...]
    text: str
    line: int


def fences(page: GuidePage) -> Iterator[Fence]:
    """All blocks of a page."""
    for match in re.finditer(r"^```([^\n]*)\n(.*?)^```$", page.text, re.MULTILINE | re.DOTALL):
        language, *words = match[1].split() or ["text"]
        yield Fence(language, tuple(words), match[2], page.text.count("\n", 0, match.start()) + 1)


#: What reads a file of YAML that is no scene, by its first key.
READERS = {
    "sweep": sweeps.read_spec,
    "design": lambda path: read_wanted(path) if is_synthesis(path) else designs.read_spec(path),
}


def run_page(page: GuidePage, folder: Path, *, slow: bool = False) -> None:
    """Runs every block in a folder of its own; raises AssertionError with the place of the first that does not hold."""
    scene = PENDULUM
    (folder / "mechanisms").symlink_to(ROOT / "mechanisms")
    for fence in fences(page):
        where = f"{page.path.name}:{fence.line}"
        assert fence.language in LANGUAGES, f"{where}: no known language"
        if "slow" in fence.words and not slow:
            continue
        reader = READERS.get(fence.text.partition(":")[0]) if fence.language == "yaml" else None
        if reader is not None:
            (folder / fence.words[0]).write_text(fence.text, encoding="utf-8")
            reader(folder / fence.words[0])
        elif fence.language == "yaml" and fence.words:
            (folder / fence.words[0]).write_text(scene := fence.text, encoding="utf-8")
            read_scene(folder / fence.words[0])
        elif fence.language == "yaml":
            (folder / "merged.yaml").write_text(_merged(scene, fence.text), encoding="utf-8")
            read_scene(folder / "merged.yaml")
        elif fence.language in ("xml", "text") and fence.words:
            (folder / fence.words[0]).write_text(fence.text, encoding="utf-8")
        elif fence.language == "console":
            _run_console(fence, folder, where)
        elif fence.language == "python" and not fence.words:
            done = python(fence.text, folder)
            assert done.returncode == 0, f"{where}: {done.stderr}"


def _merged(scene: str, part: str) -> str:
    """A scene with the blocks of a part of it: their entries beside the scene's own, or in their place; of `simulation`
    the whole block, whose keys may exclude each other."""
    whole, given = yaml.safe_load(scene), yaml.safe_load(part)
    for key, value in given.items():
        if key != "simulation" and isinstance(value, dict) and isinstance(whole.get(key), dict):
            whole[key] |= value
        else:
            whole[key] = value
    text: str = yaml.safe_dump(whole, sort_keys=False, allow_unicode=True)
    return text


def _run_console(fence: Fence, folder: Path, where: str) -> None:
    wanted = int(fence.words[fence.words.index("exit") + 1]) if "exit" in fence.words else 0
    commands = re.split(r"^\$ ", fence.text, flags=re.MULTILINE)[1:]
    assert commands, f"{where}: no line begins with '$ '"
    for number, each in enumerate(commands, 1):
        command, _, shown = each.partition("\n")
        program, *arguments = shlex.split(command, comments=True)
        if program == "cat":
            (name,) = arguments
            printed, code = (folder / name).read_text(encoding="utf-8"), 0
        elif program == "rm":
            for name in arguments:
                (folder / name).unlink()
            printed, code = "", 0
        else:
            assert program == "mbproj", f"{where}: '{program}' is not run here"
            done = mbproj(*arguments, folder=folder)
            printed, code = done.stdout + done.stderr, done.returncode
        assert code == (wanted if number == len(commands) else 0), f"{where}: {command}\nexit code {code}\n{printed}"
        _compare(shown, printed, f"{where}: {command}")


def _compare(shown: str, printed: str, where: str) -> None:
    """Every line shown has to be printed, in order, but for numbers, the width of columns and lines left out."""
    rest = iter(_plain(line) for line in printed.splitlines())
    for line in shown.splitlines():
        if (wanted := _plain(line)) and wanted != "...":
            pattern = re.escape(wanted).replace(r"\.\.\.", ".*")
            assert any(re.fullmatch(pattern, each) for each in rest), f"{where}\nno such line: {line}\nin:\n{printed}"


def _plain(line: str) -> str:
    without_numbers = re.sub(r"[-+]?\b\d+(\.\d+)?(e[-+]?\d+)?\b", "#", line)
    return re.sub(r"[\s─-]+", " ", without_numbers).strip()


def clear(folder: Path) -> None:
    """What a page left in its folder."""
    shutil.rmtree(folder, ignore_errors=True)
