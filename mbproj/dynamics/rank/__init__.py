"""Rank of C_q and what follows from it: freedoms, redundant rows, singular poses, reactions not unique."""
