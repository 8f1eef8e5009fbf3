"""Other programs and equations derived by hand beside mbproj, on the same mechanisms: `python -m scripts.beside`.

A mechanism is a scene of mbproj (`problems.py`). A file `by_NAME.py` builds its model for one program, with the tree
that mbproj's export to MJCF and URDF takes, and runs it. `measure.py` finds errors and times, and prints them.
Importing this limits all programs to one thread."""

import os

os.environ |= dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"), "1")
