"""Runs without degrees of freedom, against closed forms and against runs that integrate them."""
