"""The results file, written whole or not at all; its views, notes and analysis, which are pure functions of it."""
