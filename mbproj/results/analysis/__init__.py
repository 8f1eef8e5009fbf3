"""Pure functions of results: energy, violations, comparison, loads, contacts, expectations."""
