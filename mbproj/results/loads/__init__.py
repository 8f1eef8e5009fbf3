"""The largest loads of a run, and its works: found between samples, and stored in /summary/loads."""
