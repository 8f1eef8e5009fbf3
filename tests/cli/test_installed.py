"""mbproj as it is installed, used in a checkout: its workers are of the installed package, with its kernel. And what a
user is told whose Python takes the sources.

The installation is what a wheel unpacks to, without the minutes of compiling one: the package, its metadata and the
kernel that is loaded here in a folder of their own, and the script that pip writes. The checkout is the sources without
a kernel.
"""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import sys
from pathlib import Path
from typing import Any, NamedTuple

import h5py
import pytest

import mbproj
from mbproj.kernel import core
from tests.kernel.scenes import needs_kernel
from tests.studies.scenes import write
from tests.support import ROOT

pytestmark = needs_kernel
SCRIPT = "import sys\nfrom mbproj.commands import main\nsys.exit(main())\n"
SETTING = ("--duration", "0.5", "--step", "0.01", "--output-step", "0.01", "--projection", "gpopm")


FULL = ("run", "five_bar.yaml", "--duration", "0.02")
#: The program of `python -c`, which looks for packages in the current folder first.
IN_FOLDER = "from mbproj.commands.main import main; main()"


class Places(NamedTuple):
    """The script `mbproj` and the folder that its package is in; a checkout, and a folder with nothing in it."""

    script: Path
    packages: Path
    checkout: Path
    elsewhere: Path

    def mbproj(self, folder: Path, *arguments: str) -> subprocess.CompletedProcess[str]:
        """`mbproj ARGUMENTS`, as installed, in a folder."""
        return self.python(folder, str(self.script), *arguments)

    def python(self, folder: Path, *arguments: str, **environment: str) -> subprocess.CompletedProcess[str]:
        """`python ARGUMENTS` in a folder. -S: an editable installation would put itself before everything else."""
        path = os.pathsep.join([str(self.packages), *(entry for entry in sys.path if entry.endswith("site-packages"))])
        environment |= {"PYTHONPATH": path, "MBPROJ_CACHE": str(self.elsewhere / "cache")}
        program = [sys.executable, "-S", *arguments]
        done = subprocess.run(program, capture_output=True, text=True, cwd=folder, check=False, env=environment)
        assert done.returncode == 0, done.stderr
        return done

    @property
    def note(self) -> str:
        """What is said where Python takes the checkout."""
        cost = "so that simulations run in the full formulation, some hundred times slower"
        here, other = (folder / "mbproj" for folder in (self.checkout, self.packages))
        taken = f"Python took the sources in '{here}', not the installed '{other}'"
        return f"the compiled kernel is missing (not built), {cost}: {taken}: start it in another folder"


@pytest.fixture(scope="module")
def places(tmp_path_factory: pytest.TempPathFactory) -> Places:
    folder, extension = tmp_path_factory.mktemp("installed"), core()
    found = Places(folder / "bin" / "mbproj", folder / "packages", folder / "checkout", folder / "elsewhere")
    assert mbproj.__file__ is not None
    assert extension is not None
    assert extension.__file__ is not None
    for target in (found.packages, found.checkout):
        ignored = shutil.ignore_patterns("*.so", "*.pyd", "src", "__pycache__")
        shutil.copytree(Path(mbproj.__file__).parent, target / "mbproj", ignore=ignored)
    compiled = Path(extension.__file__).parent
    for kernel in compiled.glob("_core*"):
        shutil.copy(kernel, found.packages / "mbproj" / "kernel" / kernel.name)
    (found.checkout / "mbproj" / "kernel" / "src").mkdir()
    described = found.packages / f"mbproj-{mbproj.__version__}.dist-info"
    described.mkdir()
    (described / "METADATA").write_text(f"Name: mbproj\nVersion: {mbproj.__version__}\n", encoding="utf-8")
    found.script.parent.mkdir()
    found.script.write_text(SCRIPT, encoding="utf-8")
    found.elsewhere.mkdir()
    five_bar = (ROOT / "mechanisms" / "five_bar.yaml").read_text(encoding="utf-8")
    for target in (found.checkout, found.elsewhere):
        (target / "five_bar.yaml").write_text(five_bar, encoding="utf-8")
    return found


@pytest.fixture(scope="module")
def alone(places: Places) -> dict[str, Any]:
    """The summary of the run that a user of the installation makes elsewhere, into elsewhere/run.h5."""
    done = places.mbproj(places.elsewhere, "run", "five_bar.yaml", *SETTING, "-o", "run.h5", "--json")
    found: dict[str, Any] = json.loads(done.stdout)
    assert found["formulation"] == "planar"
    return found


def numbers(path: Path) -> dict[str, bytes]:
    """The bits of every array of numbers in a results file, but for the marks, which the clock keeps."""
    found: dict[str, bytes] = {}

    def take(name: str, item: Any) -> None:
        if isinstance(item, h5py.Dataset) and item.dtype.kind in "fiu" and not name.startswith("checkpoint/"):
            found[name] = item[()].tobytes()

    with h5py.File(path) as file:
        file.visititems(take)
    return found


def test_batch_in_a_checkout_gives_the_bits_of_run(places: Places) -> None:
    places.mbproj(places.elsewhere, "run", "five_bar.yaml", "-o", "whole.h5", "--quiet")
    done = places.mbproj(places.checkout, "batch", "five_bar.yaml", "--keep", "kept", "--json")
    (verdict,) = json.loads(done.stdout)["scenes"]
    assert (verdict["formulation"], verdict["exit_code"]) == ("planar", 0)
    here, there = numbers(places.checkout / "kept" / "five_bar.h5"), numbers(places.elsewhere / "whole.h5")
    assert len(here) > 10
    assert here == there


@pytest.mark.full
def test_a_study_in_a_checkout_gives_the_bits_of_run(places: Places, alone: dict[str, Any]) -> None:
    options = ("--projections", "gpopm,none", "--steps", "0.01", "--until", "0.5", "--repeat", "1", "--json")
    done = places.mbproj(places.checkout, "compare", "five_bar.yaml", *options)
    first, second = json.loads(done.stdout)["entries"]
    assert first["formulation"] == second["formulation"] == "planar"
    for name in ("position_violation", "velocity_violation"):
        assert first[name] == alone[f"{name}_max"]
    assert first["evaluations"] == alone["evaluations"]


@pytest.mark.full
def test_sources_without_a_kernel_are_said_once_with_what_to_do(places: Places) -> None:
    write(places.checkout, "bar")
    accurate = ("run", "bar.yaml", "--duration", "0.02", "--accuracy", "1e-3", "-o", "full.h5", "--json")
    done = places.python(places.checkout, "-c", IN_FOLDER, *accurate)
    assert json.loads(done.stdout)["formulation"] == "full"
    notes = [line for line in done.stderr.splitlines() if line.startswith("note: ")]
    assert notes == [f"note: {places.note}"]


@pytest.mark.full
@pytest.mark.parametrize(("options", "kernel"), [(["--quiet"], ""), ([], "0")], ids=["quiet", "on purpose"])
def test_who_does_not_want_to_know_is_not_told(places: Places, options: list[str], kernel: str) -> None:
    arguments = ["-c", IN_FOLDER, *FULL, "-o", "full.h5", *options]
    assert places.python(places.checkout, *arguments, MBPROJ_KERNEL=kernel).stderr == ""


@pytest.mark.full
def test_workers_leave_it_to_the_command_to_say_so(places: Places) -> None:
    folder = places.checkout / "scenes"
    for name in ("a", "b", "c"):
        write(folder, name)
    done = places.python(places.checkout, "-c", IN_FOLDER, "batch", "scenes", "--jobs", "2", "--json")
    assert {scene["formulation"] for scene in json.loads(done.stdout)["scenes"]} == {"full"}
    assert done.stderr == f"note: {places.note}\n"


@pytest.mark.full
def test_a_program_is_warned_once(places: Places) -> None:
    code = (
        "from mbproj import *\nscene = read_scene('five_bar.yaml')\n"
        "for _ in range(2):\n    solve(Mechanism.of(scene), Setting(step=0.01), sample_times(0.02, 1))"
    )
    done = places.python(places.checkout, "-c", code)
    assert done.stderr.count(f"MbprojWarning: {places.note}") == done.stderr.count("Warning") == 1


def test_the_environment_leaves_the_kernel_out_on_purpose(places: Places) -> None:
    done = places.python(places.elsewhere, str(places.script), *FULL, "-o", "no.h5", "--json", MBPROJ_KERNEL="0")
    found = json.loads(done.stdout)
    assert (found["formulation"], done.stderr) == ("full", "")
    assert found["formulation_why"] == "the compiled kernel is missing (MBPROJ_KERNEL leaves it out)"


@pytest.mark.full
def test_info_says_what_to_do_for_a_kernel(places: Places) -> None:
    done = places.python(places.checkout, "-c", IN_FOLDER, "info", "--build")
    assert f"kernel        none: not built\n  {places.note[places.note.index('Python took') :]}\n" in done.stdout
    kernel = places.checkout / "mbproj" / "kernel" / "src"
    kernel.rmdir()  # as in a package that was installed where nothing compiles
    try:
        facts = json.loads(places.python(places.checkout, "-c", IN_FOLDER, "info", "--build", "--json").stdout)
    finally:
        kernel.mkdir()
    assert facts["kernel"]["advice"].startswith("install again with --force-reinstall: pip says why")
