"""The guide as static pages that work from the disk, made by Sphinx (the extra `docs`)."""

from __future__ import annotations

import shutil
import tempfile
from contextlib import redirect_stderr, redirect_stdout
from io import StringIO
from pathlib import Path

from mbproj.errors import InputError
from mbproj.guide.pages import KINDS, ROOT, pages
from mbproj.version import __version__

CONFIGURATION = f"""
project, release = "mbproj", {__version__!r}
extensions = ["myst_parser"]
myst_heading_anchors = 3
html_theme, html_title = "furo", "mbproj {__version__}"
html_show_sourcelink = html_show_copyright = html_copy_source = False
suppress_warnings = ["misc.highlighting_failure"]
smartquotes = False  # "--step" stays as it is typed
"""


def write_site(folder: Path) -> Path:
    """Writes the pages below a folder; the page to begin with. Raises InputError where the generator is not installed
    or a page is at fault."""
    try:
        from sphinx.cmd.build import build_main
    except ImportError as error:
        raise InputError("the pages are made by Sphinx, which is not installed: pip install 'mbproj[docs]'") from error
    with tempfile.TemporaryDirectory() as temporary:
        source = Path(temporary)
        for kind in [*KINDS, "figures"]:
            shutil.copytree(ROOT / kind, source / kind)
        (source / "conf.py").write_text(CONFIGURATION, encoding="utf-8")
        (source / "index.md").write_text(_contents(), encoding="utf-8")
        said = StringIO()
        with redirect_stdout(said), redirect_stderr(said):
            failed = build_main(["-q", "-W", "--keep-going", "-b", "html", str(source), str(folder)])
        if failed:
            raise InputError(f"the guide could not be written to {folder}:\n{said.getvalue().strip()}")
    return folder / "index.html"


def _contents() -> str:
    """The first page: a list of every page below the heading of its kind, and the same for the side bar."""
    parts = ["# mbproj", "Constrained spatial mechanisms, simulated with joints that stay closed."]
    for kind, title in KINDS.items():
        listed = [page for page in pages().values() if page.kind == kind]
        parts += [f"## {title}", "\n".join(f"- [{page.title}]({kind}/{page.topic}.md)" for page in listed)]
        side_bar = "\n".join(f"{kind}/{page.topic}" for page in listed)
        parts.append(f"```{{toctree}}\n:hidden:\n:caption: {title.partition(':')[0]}\n\n{side_bar}\n```")
    return "\n\n".join(parts) + "\n"
