"""A run of one scene, recorded: the one place that compiles, assembles, simulates and writes results."""

from mbproj.registry import lazily

__getattr__ = lazily(
    __name__,
    {
        "record": "Earlier Interrupted Run notes_on notes_on_rows record_equilibrium record_run",
    },
)
