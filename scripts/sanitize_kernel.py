"""Runs the kernel's tests under the address and undefined-behaviour sanitizers, or those of tests named after `--`;
then random scenes of contacts, frictions, rolling and implicit methods, and random impacts.

    python scripts/sanitize_kernel.py
    python scripts/sanitize_kernel.py -- tests/mechanisms/rank/test_singular_passages.py

Compiles the baseline extension with both sanitizers (GCC or Clang; minutes), in a copy of the package in a temporary
folder, so that the checkout keeps its own. Needs what `pip install '.[test]'` installs, and cmake, nanobind and
cmeel-eigen. Ends with pytest's exit code; the first report of a sanitizer ends the process that it is about.
"""

from __future__ import annotations

import argparse
import os
import shutil
import subprocess
import sys
import sysconfig
import tempfile
from pathlib import Path

ROOT = Path(__file__).parents[1]
KERNEL_TESTS = ["tests/kernel", "tests/integrate/test_row_policy.py", "tests/integrate/implicit"]
#: How soon an interruption ends a run does not hold at a tenth of the speed.
NOT_BY_THE_CLOCK = "not within_a_fifth_of_a_second"
COPIED = ("mbproj", "mechanisms", "scripts", "tests", "pyproject.toml", "README.md")
SANITIZERS = "-fsanitize=address,undefined -fno-sanitize-recover=all"
#: Enough for the templates to run at a tenth of their speed. Frame pointers and tables of lines give the reports their
#: places; where variables are held is not told, which would take the compiler gigabytes and most of an hour.
#: Assertions of the standard library check each index, also one that stays within a list's capacity.
FLAGS = f"{SANITIZERS} -D_GLIBCXX_ASSERTIONS -O1 -g1 -fno-omit-frame-pointer"


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("tests", nargs="*", default=KERNEL_TESTS, help="what pytest runs")
    parser.add_argument("--scenes", type=int, default=200, help="random scenes of contacts, and of impacts")
    parser.add_argument("--minutes", type=float, default=10.0, help="no more scenes of contacts are begun after that")
    parser.add_argument("--seed", type=int, default=0)
    asked = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        copy = Path(folder) / "mbproj"
        copy_checkout(copy)
        compile_sanitized(copy)
        seed = ["--seed", str(asked.seed)]
        contacts = ["contacts", "--count", str(asked.scenes // 8), *seed, "--minutes", str(asked.minutes)]
        for command in (
            ["-m", "pytest", "-n", "2", "-m", "full", "-k", NOT_BY_THE_CLOCK, *asked.tests],
            ["scripts/random_impacts.py", "--count", str(asked.scenes), *seed],
        ):
            ended = subprocess.run([sys.executable, *command], cwd=copy, env=environment(copy), check=False).returncode
            if ended:
                return ended
        return crashes(copy, ["scripts/random_campaign.py", *contacts, "--seconds", "200"])


def crashes(copy: Path, campaign: list[str]) -> int:
    """How many scenes of a campaign ended by a signal: it judges the motion too, which is not the question here."""
    told = subprocess.run(
        [sys.executable, *campaign], cwd=copy, env=environment(copy), check=False, capture_output=True
    )
    print(told.stdout.decode(), told.stderr.decode(), sep="\n")
    return sum(line.startswith("signal") for line in told.stdout.decode().splitlines())


def copy_checkout(target: Path) -> None:
    """What the tests need, without extensions that were compiled before."""
    target.mkdir()
    for name in COPIED:
        source = ROOT / name
        if source.is_dir():
            shutil.copytree(source, target / name, ignore=shutil.ignore_patterns("*.so", "*.pyd", "__pycache__"))
        else:
            shutil.copy(source, target / name)


def compile_sanitized(copy: Path) -> None:
    """Puts the extension into the copy's `mbproj/kernel`."""
    build, site = copy / "build", sysconfig.get_paths()["purelib"]
    configure = [
        "cmake",
        "-S",
        str(copy / "mbproj/kernel"),
        "-B",
        str(build),
        f"-DCMAKE_PREFIX_PATH={site}",
        f"-DPython_EXECUTABLE={sys.executable}",
        f"-DCMAKE_CXX_FLAGS={FLAGS}",
        "-DCMAKE_BUILD_TYPE=None",
        "-DMBPROJ_PORTABLE=ON",
    ]
    compile_it = ["cmake", "--build", str(build), "-j2"]
    install = ["cmake", "--install", str(build), "--prefix", str(copy)]
    for command in (configure, compile_it, install):
        subprocess.run(command, check=True, stdout=subprocess.DEVNULL)


def environment(copy: Path) -> dict[str, str]:
    """The runtime of the sanitizers comes first into the process, which is not compiled with them, and with it that of
    C++, whose exceptions it looks for at the start. Python frees little when it ends, so that leaks cannot be told from
    its own."""
    runtimes = [
        subprocess.run(["c++", f"-print-file-name={name}"], check=True, capture_output=True, text=True).stdout.strip()
        for name in ("libasan.so", "libstdc++.so")
    ]
    return {
        **os.environ,
        "LD_PRELOAD": " ".join(runtimes),
        "ASAN_OPTIONS": "detect_leaks=0",
        "UBSAN_OPTIONS": "print_stacktrace=1",
        "MBPROJ_KERNEL": "1",
        "PYTHONPATH": str(copy),  # not the package that is installed
    }


if __name__ == "__main__":
    sys.exit(main())
