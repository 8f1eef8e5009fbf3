"""Writing a picture to a file."""

from __future__ import annotations

import warnings
from pathlib import Path
from typing import Any

from matplotlib.figure import Figure

from mbproj.figures.style import look, page_width, styled
from mbproj.output_files import picture, replacing
from mbproj.output_files.kinds import MARK

#: The metadata of each format: mbproj's mark, by which it recognises its files, and no date, so that the same results
#: give the same file.
METADATA = {
    "png": {"Software": MARK},
    "svg": {"Title": MARK, "Date": None},
    "pdf": {"Creator": MARK, "CreationDate": None},
}


@styled
def save(figure: Figure, path: Path, *, force: bool = False) -> Path:
    """Writes `figure` in the format that the suffix names.

    Raises InputError where the file cannot be written. Without `force`, it also refuses to replace a file that is no
    picture of mbproj."""
    file_format = path.suffix[1:]
    hint = "choose another directory with -o"
    with replacing(path, picture(file_format), force=force, hint=hint) as draft, warnings.catch_warnings():
        warnings.filterwarnings("ignore", message="Glyph .* missing from")  # the picture shows a box instead
        asked = look()
        if asked.height is not None:
            figure.set_size_inches(page_width(), asked.height)
        exact: dict[str, Any] = {"bbox_inches": figure.bbox_inches} if asked.width is not None else {}
        figure.savefig(draft, format=file_format, metadata=METADATA[file_format], **exact)
    return path
