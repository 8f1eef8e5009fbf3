"""The figures of the guide's pages, drawn by the commands that the pages show: mbproj/guide/figures/NAME.png.

    python scripts/draw_guide.py [NAME ...]

The colours of a figure are reduced to a palette, so that the package stays small.
"""

from __future__ import annotations

import shlex
import sys
import tempfile
from collections.abc import Mapping
from pathlib import Path
from types import MappingProxyType

from PIL import Image

sys.path.insert(0, str(Path(__file__).parents[1]))

from mbproj.guide.pages import ROOT as GUIDE
from mbproj.guide.pages import pages
from tests.cli.commands import mbproj
from tests.guide.fences import fences
from tests.support import ROOT

QUICK_RETURN = "run quick_return.yaml -o quick_return.h5"
SWING = ("run swing.yaml -o swing.h5 --certify",)
METHODS = ("none", "baumgarte", "gpopm")
#: Each figure: the commands, the last of which draws it, and the file that it writes.
FIGURES: Mapping[str, tuple[tuple[str, ...], str]] = MappingProxyType(
    {
        "swing_paths": ((*SWING, "plot swing.h5 --kind paths"), "swing-paths.png"),
        "swing_violation": ((*SWING, "plot swing.h5 --kind violation"), "swing-violation.png"),
        "swing_trust": ((*SWING, "plot swing.h5 --kind trust"), "swing-trust.png"),
        "untrusted_markers": (
            (
                "run mechanisms/five_bar.yaml --certify -o certified.h5",
                'plot certified.h5 --kind markers --error "1 mm"',
            ),
            "certified-markers.png",
        ),
        "methods_violation": (
            (
                *(f"run mechanisms/five_bar.yaml --projection {each} --duration 5 -o {each}.h5" for each in METHODS),
                f"plot {' '.join(f'{each}.h5' for each in METHODS)} --kind violation",
            ),
            "none-violation.png",
        ),
        "compare": (
            ("compare mechanisms/five_bar.yaml --projections none,baumgarte,gopm,gpopm --until 3",),
            "five_bar-compare.png",
        ),
        "work_precision": (
            ("tradeoff mechanisms/physical_pendulum.yaml --until 2 --projections gpopm,none",),
            "physical_pendulum-tradeoff.png",
        ),
        "stability_step": (
            ("stability mechanisms/physical_pendulum.yaml --vary step",),
            "physical_pendulum-stability-step.png",
        ),
        "tradeoff_five_bar": (("tradeoff mechanisms/five_bar.yaml --until 5",), "five_bar-tradeoff.png"),
        "threshold_slider_crank": (
            ("threshold mechanisms/spatial_slider_crank.yaml",),
            "spatial_slider_crank-threshold.png",
        ),
        "quick_return_markers": (
            (QUICK_RETURN, "plot quick_return.h5 --kind markers"),
            "quick_return-markers.png",
        ),
        "sweep_map": (("sweep lengths.yaml", "plot lengths-sweep --kind map"), "lengths-sweep-map.png"),
        "tolerances_distribution": (
            ("sweep tolerances.yaml", "plot tolerances-sweep --kind distribution"),
            "tolerances-sweep-distribution.png",
        ),
        "tolerances_sobol": (("sweep shares.yaml", "plot shares-sweep --kind sobol"), "shares-sweep-sobol.png"),
        "bennett_reactions": (
            ('run mechanisms/bennett.yaml --duration "0.2 s" -o bennett.h5', "plot bennett.h5 --kind reactions"),
            "bennett-reactions.png",
        ),
    }
)
#: Figures that no command draws: `python scripts/growth.py --figure mbproj/guide/figures/growth.png` in ten minutes,
#: and `python -m scripts.beside long-crank-rocker-10000 .. --figure FILE` of all long motions in a quarter of an hour.
MEASURED = frozenset({"growth", "long_energy"})
COLOURS = 64


def main() -> None:
    with tempfile.TemporaryDirectory() as temporary:
        folder = Path(temporary)
        (folder / "mechanisms").symlink_to(ROOT / "mechanisms")
        for topic in ("getting_started", "model_my_own_mechanism", "run_a_sweep", "how_tolerances_scatter"):
            for fence in fences(pages()[topic]):
                if fence.language == "yaml" and fence.words:
                    (folder / fence.words[0]).write_text(fence.text, encoding="utf-8")
        done: set[str] = set()
        for name in sys.argv[1:] or FIGURES:
            commands, picture = FIGURES[name]
            for command in commands:
                if command not in done:
                    _run(command, folder)
                    done.add(command)
            print(_reduced(folder / picture, GUIDE / "figures" / f"{name}.png"))


def _run(command: str, folder: Path) -> None:
    finished = mbproj(*shlex.split(command), folder=folder)
    if finished.returncode:
        raise SystemExit(f"mbproj {command}\n{finished.stderr}")


def _reduced(picture: Path, path: Path) -> str:
    """Writes the picture with few colours; its name and size."""
    Image.open(picture).convert("RGB").quantize(COLOURS).save(path, optimize=True)
    return f"{path.name}: {path.stat().st_size / 1000:.0f} kB"


if __name__ == "__main__":
    main()
