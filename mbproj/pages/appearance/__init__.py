"""The appearance of a mechanism, apart from its motion: solids on bodies, glyphs of joints, springs, and the view.

Nothing here draws. A change here changes pages and pictures alike.
"""
