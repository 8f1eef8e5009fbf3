"""Rank of C_q and what follows: degrees of freedom, redundant rows, singular poses, unique reactions."""
