"""Texts to put where a number, a name or a path belongs."""

from __future__ import annotations

from random import Random

NUMBERS = (
    "0", "-0.0", "1", "-1", "2", "7", "1e-3", "0.1", "1e3", "1e9", "1e18", "1e39", "1e40", "-1e40", "1e41", "1e150",
    "1e200", "-1e200", "1e300", "1e308", "-1e308", "1.8e308", "1e999", "1e-9", "1e-16", "1e-30", "1e-40", "1e-150",
    "1e-300", "1e-308", "5e-324", "1e-999", "nan", "inf", "-inf", "2147483647", "2147483648", "9223372036854775808",
    "4503599627370497", "1.5", "3.14159", "180", "360", "1_000", "0x10", "1e", "e1", ".", "1.2.3", "+1", "--1",
)  # fmt: skip
UNITS = ("", "", "", " s", " ms", " m", " mm", " kg", " deg", " rad", " N", " Hz", " 1/s", " m/s", " furlong", "%")
EXPRESSIONS = (
    "1/0", "0/0", "1e200**2", "(-1)**0.5", "sqrt(-1)", "log(0)", "exp(1000)", "max()", "min(1,2)", "atan2(0,0)", "t",
    "x", "pi", "sin(1", "sin 1", "1 2", "()", "2**2**2**2**2**9", "(" * 400 + "1" + ")" * 400, "-" * 3000 + "1",
    "+".join(["1"] * 3000), "2*" * 3000 + "2", "9" * 5000, "a" * 5000, "1e308*10", "1 s * 1 m", "5 mm + 3 deg",
)  # fmt: skip
TEXTS = (
    "", " ", "\t", "\n", "a", "A.b", "../x", "..", "*", "[", "**", "'", '"', "$", "$\\frac{", "\\", "%s", "{0}",
    "=1+1", "@x", "-", "--", "-x", "null", "true", "no", "~", "ground", "\x1b[31mred", "\x1b]0;t\x07", "\x9b2J", "\x07",
    "\r", "Δ", "é", "日本", "\u202eabc", "\ufeff", "\udcff", "💥", "a,b", "a:b", "a=b", "name=1", "=", "NAME=", "gpopm",
    "rk4", "full", "planar", "png", "x" * 300, "y" * 5000,
)  # fmt: skip
#: Names of what lies in the folder (see `surroundings`), and of what does not.
PATHS = (
    "scene.yaml", "spatial.yaml", "short.h5", "other.h5", "part.h5.part", "foreign.txt", "foreign.csv", "empty", "pipe",
    "folder", "link", "dangling", "loop", ".", "..", "", "/dev/null", "/dev/full", "/dev/zero", "missing", "no/x",
    "scene.yaml/x", "\udcff.yaml", "\x1b[31m.yaml", "new.csv", "new.h5", "z" * 300, "p/" * 3000 + "q", "*.yaml",
    "folder/*", "**/*", "locked/x",
)  # fmt: skip


def any_value(random: Random) -> str:
    """Something for an option."""
    kind = random.random()
    if kind < 0.5:
        return number(random)
    return random.choice(EXPRESSIONS if kind < 0.65 else TEXTS if kind < 0.9 else PATHS)


def number(random: Random) -> str:
    """A number with a unit or without."""
    if random.random() < 0.5:
        return f"{10 ** random.uniform(-60, 60):.3g}{random.choice(UNITS)}"
    return random.choice(NUMBERS) + random.choice(UNITS)


def path(random: Random) -> str:
    """Something for a path."""
    return random.choice(PATHS if random.random() < 0.9 else TEXTS)
