"""The output of commands: summaries, tables, diagnoses, JUnit."""
