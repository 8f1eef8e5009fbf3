"""The largest loads of a run, and its works: found between samples, kept in /summary/loads."""
