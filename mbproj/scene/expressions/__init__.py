"""Expressions with units: tokens, a syntax tree, a value or a program."""
