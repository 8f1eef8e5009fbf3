"""Other programs and hand-derived equations for bench_peers.py. Importing this limits all of them to one thread."""

import os

os.environ |= dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"), "1")
