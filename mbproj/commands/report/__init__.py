"""What commands print: tables, summaries, progress, JUnit."""
