"""What commands print: summaries, tables, diagnoses, JUnit."""
