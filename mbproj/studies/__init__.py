"""What runs many simulations: comparisons, trade-offs, recommendations, certificates, batches, the paper's examples."""

from mbproj.registry import lazily

__getattr__ = lazily(
    __name__,
    {
        "batch": "SceneResult Task run_task tasks",
        "measure.timing": "time_settings",
        "parallel.progress": "TIMING with_words",
        "recommend.write_back": "write_back",
        "stability.quantities": "QUANTITIES",
        "sweep.design": "saltelli",
        "variants.livelier": "with_damping with_speed with_stiffness",
        "variants.moved": "RigidMotion",
        "variants.rescaled": "rescaled",
        "verify.case": "Case",
        "verify.checks": "CHECKS",
        "verify.finding": "Finding",
        "verify.invariance": "renumbered",
    },
)
