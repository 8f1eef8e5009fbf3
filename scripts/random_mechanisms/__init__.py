"""Random mechanisms, and what the formulations have to agree on."""
