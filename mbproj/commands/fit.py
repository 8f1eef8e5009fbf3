"""`mbproj fit` and `mbproj.fit`: numbers of a scene that match measurements."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

from mbproj.commands.declared import Asked, command_of, declared, read
from mbproj.commands.design_command import OUTPUT, Engine, Spec, found, search
from mbproj.commands.figure_options import look
from mbproj.commands.study_options import FreshWork, answer

if TYPE_CHECKING:
    from typing_extensions import Unpack

    from mbproj.studies.design.run import FoundDesign

EXAMPLES = (
    ("Fit lengths to a measured path.", "mbproj fit path.yaml"),
    ("Go on where it was interrupted, on four processors.", "mbproj fit path.yaml -j 4"),
)


@declared
def fit(spec: Spec, *, engine: Engine = None, **effort: Unpack[FreshWork]) -> FoundDesign:
    """Finds the numbers of a scene that match measurements.

    SPEC is a YAML file: a scene, what varies within which bounds, which quantity matches which columns of a CSV file.
    Prints the numbers with their standard deviations, and which of them the measurements do not show. Writes
    best.yaml, starts.csv and design.png into DIR.

    Exit code 0: done; 2: wrong input, or no design runs; 3: no design keeps the constraints.

    In Python nothing is written: `best_scene` has the text. Finished starts are not searched again, unless `fresh`.
    Raises InputError where the file, its scene or its measurements are wrong, or no design runs.
    """
    return found(read(fit, locals()), fits=True)


@command_of(fit, EXAMPLES, answer, OUTPUT, look)
def command(asked: Asked[FoundDesign], output: Path | None, **options: Any) -> int:
    return search(asked, output, options)
