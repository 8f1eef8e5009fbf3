"""What moves, made small: which samples a page shows, the series of its charts, and their bytes.

Numbers are whole multiples of a step, kept as differences in time; nothing is interpolated here.
"""
