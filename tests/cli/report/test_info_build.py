"""info --build: what runs, and how the kernel was compiled."""

from __future__ import annotations

import json
import platform

import h5py
import numpy as np
import pytest

from mbproj import __version__, kernel
from mbproj.base.registry import FORMULATIONS
from tests.cli.commands import mbproj


def facts(folder):
    done = mbproj("info", "--build", "--json", folder=folder)
    assert (done.returncode, done.stderr) == (0, "")
    return json.loads(done.stdout)


def test_versions_and_formulations(tmp_path):
    has = facts(tmp_path)
    versions = {"mbproj": __version__, "python": platform.python_version()}
    assert has.items() >= {**versions, "numpy": np.__version__, "h5py": h5py.__version__}.items()
    assert {"auto", *has["formulations"]} == set(FORMULATIONS)


def test_the_kernel_is_the_one_in_use(tmp_path):
    has, build = facts(tmp_path)["kernel"], kernel.build_info()
    if isinstance(build, str):
        assert (has["built"], has["reason"]) == (False, build)
    else:
        assert has == {"built": True, **build}
        assert {"compiler", "flags", "build_type", "eigen", "instruction_set"} <= set(build)
        assert "-ffast-math" not in build["flags"]


def test_text_says_the_same(tmp_path):
    done = mbproj("info", "--build", folder=tmp_path)
    assert (done.returncode, done.stderr) == (0, "")
    build = kernel.build_info()
    assert f"mbproj        {__version__}\n" in done.stdout
    if isinstance(build, str):
        assert f"kernel        none: {build}\n" in done.stdout
    else:
        assert f"kernel        {build['instruction_set']}\n  compiler    {build['compiler']}\n" in done.stdout


@pytest.mark.parametrize("arguments", [[], ["--json"], ["--build", "a.h5"]])
def test_either_a_file_or_the_build(tmp_path, arguments):
    done = mbproj("info", *arguments, folder=tmp_path)
    assert (done.returncode, done.stdout) == (2, "")
    assert "give RESULTS, a results file, or --build, for how mbproj itself was built" in done.stderr
