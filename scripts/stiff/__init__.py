"""Stiff mechanisms with a dial, and what their runs cost: see `scripts/stiff_work_precision.py`."""
