"""Expressions with units: tokens, syntax tree, value or program. A unit is an entry of a table in `units`."""
