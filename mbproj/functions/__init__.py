"""Functions that a scene gives (of time, or of a length and its rate), as flat programs that any language can run."""

from mbproj.registry import lazily

__getattr__ = lazily(
    __name__,
    {
        "curve": "Curve",
        "curves.laws": "LAWS",
        "curves.shapes": "ellipse",
        "curves.track": "Track",
        "program": "CHANNELS COORDINATE Instruction Op Program TIME variable",
        "program_set": "flatten",
        "series": "constant_series time_series",
        "table": "CubicTable periodic spline",
    },
)
