"""Mutations of the sources, and which test catches each: what the tests catch, measured.

    python scripts/mutations.py [--only NAME ...] [--full] [--first] [-n PROCESSES] [--folder FOLDER]

`mutations.yaml` beside this file has the mutations: name, file, old text, new text, and the tests that are tried first.
They are applied one at a time in a copy of the checkout. The kernel is compiled again where the file is one of its
sources. Where the tests tried first pass, the whole run follows: the usual one, or `-m full` with `--full`; none with
`--first`.

The table has each mutation, its file, the processor time of all tests up to the one that fails, this test and its
seconds. A test that fails without the mutation, too, catches nothing. Ends with 1 where a mutation survives, or cannot
be made: where its old text does not occur once, it does not compile, or its tests do not run.

Needs what `pip install '.[test]'` installs, cmake, nanobind and cmeel-eigen. Without `--folder` the kernel is compiled
in a temporary folder, some minutes; a folder that is kept is compiled in once.
"""

from __future__ import annotations

import argparse
import importlib.util
import os
import resource
import shutil
import signal
import subprocess
import sys
import tempfile
import xml.etree.ElementTree as ET
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

import yaml

ROOT = Path(__file__).parents[1]
TABLE = Path(__file__).with_suffix(".yaml")
KERNEL = "mbproj/kernel"
#: Results do not depend on the level, and this one compiles fastest.
FLAGS = "-O1 -DNDEBUG"
#: A mutation may make a loop endless: tests that take longer, s, count as failed.
LONGEST = 1800.0


@dataclass(frozen=True)
class Mutation:
    """A change of one place in the sources: `old` occurs once in `file`, and becomes `new`. `tests` are tried first."""

    name: str
    file: str
    old: str
    new: str
    tests: tuple[str, ...]

    @property
    def is_compiled(self) -> bool:
        """Whether the kernel has to be compiled again."""
        return self.file.startswith(f"{KERNEL}/src")


class NotMadeError(Exception):
    """A mutation that cannot be made, or tests that do not run; why."""


@dataclass(frozen=True)
class Tried:
    """The test that failed in a run, "" for none, its own seconds, and the processor time of the run in s."""

    caught_by: str
    seconds: float
    processor: float


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--only", nargs="+", metavar="NAME", help="only these mutations")
    parser.add_argument("--full", action="store_true", help="`-m full`, where the tests tried first pass")
    parser.add_argument("--first", action="store_true", help="only the tests tried first")
    parser.add_argument("-n", dest="processes", default="2", help="processes of pytest")
    parser.add_argument("--folder", type=Path, help="where the copy is made, and kept")
    asked = parser.parse_args()
    mutations = read_table()
    if unknown := {*(asked.only or ())} - {each.name for each in mutations}:
        parser.error(f"unknown: {', '.join(sorted(unknown))}")
    chosen = [each for each in mutations if not asked.only or each.name in asked.only]
    with tempfile.TemporaryDirectory() as temporary:
        copy = Copy((asked.folder or Path(temporary)).resolve(), asked.processes)
        copy.update()
        whole = None if asked.first else ["-m", "full"] if asked.full else []
        survivors = [each.name for each in chosen if not is_caught(copy, each, whole)]
    print(f"{len(chosen) - len(survivors)} of {len(chosen)} caught", *survivors, sep="\n  survived: ")
    return 1 if survivors else 0


def read_table() -> list[Mutation]:
    """All mutations, in the order of the table."""
    table = yaml.safe_load(TABLE.read_text())
    return [Mutation(name, row["file"], row["old"], row["new"], tuple(row["tests"])) for name, row in table.items()]


def is_caught(copy: Copy, mutation: Mutation, whole: Sequence[str] | None) -> bool:
    """Apply a mutation, run the tests until one fails, and print the row of the table. `whole` are the arguments of the
    whole run, None for none."""
    tried = Tried("", 0.0, 0.0)
    try:
        with copy.mutated(mutation):
            tried = copy.test(*mutation.tests)
            if not tried.caught_by and whole is not None:
                again = copy.test(*whole)
                tried = Tried(again.caught_by, again.seconds, tried.processor + again.processor)
        if tried.caught_by.startswith("tests/") and copy.test(tried.caught_by).caught_by:
            raise NotMadeError(f"fails without the mutation, too: {tried.caught_by}")
        said = f"{tried.caught_by} ({tried.seconds:.1f} s)" if tried.caught_by else "SURVIVED"
    except NotMadeError as error:
        tried, said = Tried("", 0.0, tried.processor), f"NOT MADE: {error}"
    print(f"{mutation.name:32} {mutation.file.removeprefix('mbproj/'):48} {tried.processor:6.0f} s  {said}", flush=True)
    return bool(tried.caught_by)


class Copy:
    """A copy of the checkout in `folder`/tree, whose kernel is compiled in `folder`/build."""

    def __init__(self, folder: Path, processes: str) -> None:
        self.tree, self._build, self._clean = folder / "tree", folder / "build", folder / "clean"
        self._report, self._processes = folder / "report.xml", processes

    def update(self) -> None:
        """Copy the files of the checkout that differ, and compile what they change."""
        listed = subprocess.run(
            ["git", "ls-files", "-z", "--cached", "--others", "--exclude-standard"],
            cwd=ROOT,
            check=True,
            capture_output=True,
        ).stdout.decode()
        names = {name for name in listed.split("\0") if name and (ROOT / name).is_file()}
        for name in names:
            target, new = self.tree / name, (ROOT / name).read_bytes()
            if not target.exists() or target.read_bytes() != new:
                target.parent.mkdir(parents=True, exist_ok=True)
                target.write_bytes(new)
        for found in self.tree.rglob("*"):
            if found.suffix in (".py", ".cpp", ".hpp", ".yaml") and str(found.relative_to(self.tree)) not in names:
                found.unlink()
        nanobind = importlib.util.find_spec("nanobind")
        if nanobind is None or nanobind.origin is None:
            raise SystemExit("nanobind is missing: pip install nanobind cmeel-eigen")
        subprocess.run(
            [
                "cmake",
                *("-S", str(self.tree / KERNEL), "-B", str(self._build)),
                f"-DCMAKE_PREFIX_PATH={Path(nanobind.origin).parents[1]}",
                f"-DPython_EXECUTABLE={sys.executable}",
                "-DCMAKE_BUILD_TYPE=Release",
                f"-DCMAKE_CXX_FLAGS_RELEASE={FLAGS}",
            ],
            check=True,
            stdout=subprocess.DEVNULL,
        )
        try:
            self._compile()
        except NotMadeError as error:
            raise SystemExit(f"without a mutation: {error}") from None
        # The state to which each mutation is taken back: its files keep their times, so that nothing is compiled twice.
        shutil.rmtree(self._clean, ignore_errors=True)
        shutil.copytree(self._build, self._clean)

    @contextmanager
    def mutated(self, mutation: Mutation) -> Iterator[None]:
        """The copy with a mutation."""
        path = self.tree / mutation.file
        text, times = path.read_text(), path.stat()
        if (count := text.count(mutation.old)) != 1:
            raise NotMadeError(f"the old text occurs {count} times")
        # Byte code counts as that of a file of the same second and size.
        byte_code = Path(importlib.util.cache_from_source(path))
        byte_code.unlink(missing_ok=True)
        path.write_text(text.replace(mutation.old, mutation.new))
        try:
            if mutation.is_compiled:
                self._compile()
            yield
        finally:
            path.write_text(text)
            os.utime(path, ns=(times.st_atime_ns, times.st_mtime_ns))
            byte_code.unlink(missing_ok=True)
            if mutation.is_compiled:
                shutil.rmtree(self._build)
                shutil.copytree(self._clean, self._build)
                self._install()

    def test(self, *arguments: str) -> Tried:
        """Run pytest up to the first test that fails."""
        self._report.unlink(missing_ok=True)
        command = [sys.executable, "-m", "pytest", "-x", "-n", self._processes, "--tb=no", "-p", "no:cacheprovider"]
        report = ["-o", "junit_family=xunit1", f"--junitxml={self._report}"]
        own = {name: value for name, value in os.environ.items() if name != "PYTHONDONTWRITEBYTECODE"}
        before = _processor()
        with subprocess.Popen(
            [*command, *report, *arguments],
            cwd=self.tree,
            env={**own, "MBPROJ_KERNEL": "1", "PYTHONPATH": str(self.tree)},
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            start_new_session=True,
        ) as running:
            try:
                told = running.communicate(timeout=LONGEST)[0].decode()
            except subprocess.TimeoutExpired:
                os.killpg(running.pid, signal.SIGKILL)
                return Tried("no end", LONGEST, _processor() - before)
        if running.returncode not in (0, 1, 2):
            raise NotMadeError(f"pytest ended with {running.returncode}: {told.strip()[-1000:]}")
        return Tried(*self._failed(running.returncode), _processor() - before)

    def _failed(self, code: int) -> tuple[str, float]:
        """The test that failed, and its seconds."""
        if code == 0:
            return "", 0.0
        for case in ET.parse(self._report).iter("testcase") if self._report.exists() else ():
            if case.find("failure") is not None or case.find("error") is not None:
                return f"{case.get('file')}::{case.get('name')}", float(case.get("time", 0.0))
        return "a process that ended", 0.0

    def _compile(self) -> None:
        compiled = subprocess.run(["cmake", "--build", str(self._build), "-j2"], check=False, capture_output=True)
        if compiled.returncode:
            said = compiled.stdout.decode() + compiled.stderr.decode()
            raise NotMadeError(f"does not compile: {said.strip()[-1000:]}")
        self._install()

    def _install(self) -> None:
        install = ["cmake", "--install", str(self._build), "--prefix", str(self.tree)]
        subprocess.run(install, check=True, stdout=subprocess.DEVNULL)


def _processor() -> float:
    """The processor time of the processes that have ended, s."""
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


if __name__ == "__main__":
    sys.exit(main())
