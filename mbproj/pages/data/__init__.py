"""The motion as compact data: the samples that a page shows, the series of its charts, and their bytes.

Numbers are integer multiples of a step, stored as differences in time. Nothing is interpolated here.
"""
