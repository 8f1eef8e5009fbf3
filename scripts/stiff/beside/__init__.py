"""Other programs on stiff mechanisms: see `scripts/stiff_beside_peers.py`."""
