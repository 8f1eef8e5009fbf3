"""The appearance of a mechanism: solids on bodies, glyphs of joints and forces, the view."""
