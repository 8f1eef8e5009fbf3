"""Encoders of pictures into a film: a GIF by Pillow, which Matplotlib brings, or an MP4 by ffmpeg, where it is
installed."""

from __future__ import annotations

import shutil
import subprocess
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from types import MappingProxyType
from typing import Any

import numpy as np
import numpy.typing as npt

from mbproj.errors import InputError, Problem
from mbproj.outputs.kinds import MARK

#: A picture (h, w, 3) of bytes, with even width and height.
Picture = npt.NDArray[np.uint8]
#: A function that writes pictures, so many a second, to a path.
Encoder = Callable[[Iterator[Picture], int, Path], None]


def gif(pictures: Iterator[Picture], rate: int, path: Path) -> None:
    """Write a GIF; each picture has its own colours, up to 256."""
    from PIL import Image

    first, *others = (Image.fromarray(picture).quantize(256, Image.Quantize.FASTOCTREE) for picture in pictures)
    options: dict[str, Any] = {"duration": 1000 // rate, "loop": 0, "comment": MARK.encode(), "optimize": False}
    first.save(path, format="GIF", save_all=True, append_images=others, **options)


def mp4(pictures: Iterator[Picture], rate: int, path: Path) -> None:
    """Write H.264, which browsers and slides play."""
    first = next(pictures)
    height, width, _ = first.shape
    given = ["-f", "rawvideo", "-pix_fmt", "rgb24", "-s", f"{width}x{height}", "-r", str(rate), "-i", "-"]
    made = ["-c:v", "libx264", "-crf", "20", "-pix_fmt", "yuv420p", "-metadata", f"comment={MARK}", "-f", "mp4"]
    command = [ffmpeg(), "-y", "-loglevel", "error", *given, *made, str(path)]
    with subprocess.Popen(command, stdin=subprocess.PIPE, stderr=subprocess.PIPE) as process:
        assert process.stdin is not None and process.stderr is not None
        try:
            process.stdin.write(first.tobytes())
            for picture in pictures:
                process.stdin.write(picture.tobytes())
            process.stdin.close()
        except BrokenPipeError:  # ffmpeg has ended; its message tells why
            pass
        said = process.stderr.read().decode("utf-8", "replace").strip()
    if process.returncode != 0:
        message = f"ffmpeg cannot make the film: {said.splitlines()[-1] if said else process.returncode}"
        raise InputError(Problem(message, hint="install one with libx264, or end the name in .gif"))


def ffmpeg() -> str:
    """The path of ffmpeg. Raises InputError where it is not installed."""
    found = shutil.which("ffmpeg")
    if found is None:
        message = "a film in MP4 needs ffmpeg, which is not here"
        raise InputError(Problem(message, hint="install it (apt install ffmpeg), or end the name in .gif"))
    return found


ENCODERS: Mapping[str, Encoder] = MappingProxyType({"gif": gif, "mp4": mp4})
