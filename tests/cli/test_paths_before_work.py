"""A path that cannot be written is refused before the work, by every command that writes one."""

from __future__ import annotations

import pytest

from tests.cli.commands import FIVE_BAR, mbproj

BEFORE = {
    "verify-plot": ("verify", FIVE_BAR, "--plot", "nowhere/v.png"),
    "run": ("run", FIVE_BAR, "-o", "nowhere/a.h5"),
    "accuracy": ("run", FIVE_BAR, "--accuracy", "1e-3", "-o", "nowhere/a.h5"),
    "branches": ("branches", FIVE_BAR, "--picture", "nowhere/a.png"),
    "check": ("check", FIVE_BAR, "--picture", "nowhere/a.html"),
    "curve": ("curve", FIVE_BAR, "-o", "nowhere/a.csv"),
    "compare": ("compare", FIVE_BAR, "--write-table", "nowhere/a.csv"),
    "modes": ("modes", FIVE_BAR, "-o", "nowhere/m.h5"),
    "linearize": ("linearize", FIVE_BAR, "--inputs", "a", "--outputs", "b", "-o", "nowhere/m.h5"),
    "equilibrium": ("equilibrium", FIVE_BAR, "-o", "nowhere/e.h5"),
    "import": ("import", "none.xml", "-o", "nowhere/a.yaml"),
    "export": ("export", FIVE_BAR, "--mjcf", "nowhere/a.xml"),
    "loads": ("loads", FIVE_BAR, "-o", "nowhere/a.csv"),
    "animate": ("animate", FIVE_BAR, "-o", "nowhere/a.html"),
    "batch": ("batch", FIVE_BAR, "--junit", "nowhere/x.xml"),
    "recommend": ("recommend", FIVE_BAR, "--error", "1e-3", "--plot", "nowhere/x.png"),
    "tradeoff": ("tradeoff", FIVE_BAR, "--write-table", "nowhere/x.tex"),
    "info": ("info", "none.h5", "--loads", "--write-table", "nowhere/x.csv"),
}


@pytest.mark.parametrize("words", BEFORE.values(), ids=BEFORE)
def test_a_path_in_a_folder_that_is_not_there_is_refused_before_the_work(words, tmp_path):
    """What is asked for is wrong, too, or would take long: only the path is looked at."""
    done = mbproj(*words, folder=tmp_path)
    assert done.returncode == 2 and not done.stdout
    assert "the directory 'nowhere' of" in done.stderr
    assert "does not exist" in done.stderr and "traceback" not in done.stderr.lower()
    assert list(tmp_path.iterdir()) == []
