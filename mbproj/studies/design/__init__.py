"""Designs: parameters of a scene that match measurements, or make a measure as small or as large as it can be.

Begin with `spec` (what is wanted), `trial` (one design run and measured), then the searches."""
