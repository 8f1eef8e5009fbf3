"""Before NumPy loads: one BLAS thread a worker. The matrices are small, and workers that share cores only get in each
other's way; the command line does the same."""

from __future__ import annotations

import os

for variable in ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS"):
    os.environ.setdefault(variable, "1")
