"""What a mechanism looks like, apart from its motion: solids on bodies, glyphs of joints, springs, where to look from.

Nothing here draws. Change it, and pages and pictures change alike.
"""
