"""Rank of C_q and its consequences: degrees of freedom, redundant rows, singular poses, reactions that are not
unique."""
