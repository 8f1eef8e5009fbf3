"""The contacts of a run: what its stops and dry frictions have done."""
