"""The film of a mechanism: its picture (`mechanism`) at one time after another."""

from __future__ import annotations

import shutil
import subprocess
from collections.abc import Callable, Iterator, Mapping, Sequence
from pathlib import Path
from types import MappingProxyType
from typing import Any

import numpy as np
import numpy.typing as npt
from matplotlib.backends.backend_agg import FigureCanvasAgg

from mbproj.arrays import Array
from mbproj.errors import InputError, Problem
from mbproj.figures.kinds.mechanism import GHOST, MOST_PATHS, canvas, limits, nearest
from mbproj.figures.kinds.poses import draw_pose, projected
from mbproj.figures.style import line, styled
from mbproj.output_files import film, replacing
from mbproj.output_files.kinds import MARK
from mbproj.pages.appearance.mechanism import Look, look_of
from mbproj.pages.appearance.motion import PoseHistory
from mbproj.pages.appearance.recorded import motion_of
from mbproj.pages.appearance.view import View, view_of
from mbproj.results import Results

#: A picture (h, w, 3) of bytes, with even width and height.
Picture = npt.NDArray[np.uint8]
#: A function that writes pictures to a path, with a number of pictures a second.
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
    program = shutil.which("ffmpeg")
    if program is None:
        message = "a film in MP4 needs ffmpeg, which is not here"
        raise InputError(Problem(message, hint="install it (apt install ffmpeg), or end the name in .gif"))
    return program


ENCODERS: Mapping[str, Encoder] = MappingProxyType({"gif": gif, "mp4": mp4})


#: Pictures a second, as a GIF can state exactly and browsers show; the shortest and the longest film, s.
RATE, SHORTEST, LONGEST = 20, 4.0, 15.0
DOTS_PER_INCH = 110


@styled
def save_film(results: Sequence[Results], path: Path, *, force: bool = False) -> Path:
    """Writes the film in the format that the ending names: the first result, with the others in paler colours.

    Raises InputError where ffmpeg is missing, or the file must not be replaced."""
    file_format = path.suffix[1:].lower()
    if file_format == "mp4":
        ffmpeg()  # raises before any work
    with replacing(path, film(file_format), force=force) as draft:
        ENCODERS[file_format](pictures(results), RATE, draft)
    return path


def duration_and_speed(span: float) -> tuple[float, float]:
    """The duration of a film of a motion of `span` seconds, and its speed relative to the motion."""
    if span <= 0.0:
        return 1.0 / RATE, 1.0
    seconds = float(np.clip(span, SHORTEST, LONGEST))
    return seconds, span / seconds


def times_of(time: Array) -> Array:
    """The times (s) of the pictures of a motion with samples at `time`."""
    seconds, _ = duration_and_speed(float(time[-1] - time[0]))
    return np.linspace(time[0], time[-1], round(RATE * seconds) + 1 if len(time) > 1 else 1)


def pictures(results: Sequence[Results]) -> Iterator[Picture]:
    """Yield all pictures of the film, in order."""
    scenes, motions = [each.scene for each in results], [motion_of(each) for each in results]
    looks = [look_of(*each) for each in zip(scenes, motions, [each.meshes() for each in results], strict=True)]
    view = view_of(scenes[0], motions[0], looks[0])
    stage = _Stage(looks[0], motions[0], view)
    for time in times_of(motions[0].time[motions[0].finite]):
        for number, (look, motion) in enumerate(zip(looks, motions, strict=True)):
            opacity, order = (GHOST, 1.5) if number else (1.0, 2.0)
            pose = motion.at([nearest(motion, time)])
            draw_pose(stage.axis, look, view, pose, opacity=opacity, order=order)
        yield stage.picture(float(time))


class _Stage:
    """The panel on which poses are drawn, with the paths of markers up to the current time."""

    def __init__(self, look: Look, motion: PoseHistory, view: View) -> None:
        figure, self.axis = canvas(view)
        figure.set_dpi(DOTS_PER_INCH)
        limits(self.axis, view)
        markers = look.markers[:MOST_PATHS]
        self._times = motion.time
        self._paths = [projected(motion.point(each.body, each.point), view) for each in markers]
        looks = [line(number + 1) | {"linewidth": 0.8, "zorder": 1.8} for number in range(len(markers))]
        self._trails = [self.axis.plot([], [], **each)[0] for each in looks]
        times = times_of(motion.time[motion.finite])
        _, self._speed = duration_and_speed(float(times[-1] - times[0]))
        self._title = self.axis.set_title(" ", fontsize="small", loc="left")
        self._canvas = FigureCanvasAgg(figure)
        self._canvas.draw()  # type: ignore[no-untyped-call]
        figure.set_layout_engine("none")  # the layout is fixed from here on
        self._kept = set(self.axis.get_children())

    def picture(self, time: float) -> Picture:
        """Draw the panel at this time and return the picture; then remove the poses."""
        speed = "" if abs(self._speed - 1.0) < 1e-9 else f", {self._speed:.2g} times as fast"
        self._title.set_text(f"t = {time:.3f} s{speed}")
        so_far = self._times <= time + 1e-9 * max(abs(time), 1.0)
        for trail, path in zip(self._trails, self._paths, strict=True):
            trail.set_data(*path[so_far].T)
        self._canvas.draw()  # type: ignore[no-untyped-call]
        drawn = np.array(memoryview(self._canvas.buffer_rgba()))[..., :3]  # type: ignore[no-untyped-call]
        for artist in set(self.axis.get_children()) - self._kept:
            artist.remove()
        return _even(drawn)


def _even(picture: Picture) -> Picture:
    """The picture without a last row or column that would make an odd number."""
    height, width, _ = picture.shape
    return np.ascontiguousarray(picture[: height - height % 2, : width - width % 2])
