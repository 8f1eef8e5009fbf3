"""A run of one scene, recorded: the one place that compiles, assembles, simulates and writes results."""

from mbproj.registry import lazily

__getattr__ = lazily(
    __name__,
    {
        "notes": "notes_on notes_on_rows",
        "record": "Earlier Interrupted Run record_equilibrium record_run",
    },
)
