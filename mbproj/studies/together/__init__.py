"""Runs of many scenes by arrays: those that differ in numbers alone are made ready and measured together."""
