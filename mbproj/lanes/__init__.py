"""Arrays of many cases at once: code that is written for the numbers of one mechanism runs for a block of cases."""

from mbproj.lanes.array import HOW, Lanes, LanesMet, Parted
from mbproj.lanes.each import Each, OfLanes, each_call, each_lane, lane, restacked
from mbproj.lanes.functions import called
from mbproj.lanes.made import contiguous, filled_like, first_axis_innermost, like_others, numbers, one_of
from mbproj.lanes.ufuncs import applied

HOW.update(ufunc=applied, function=called, each=each_call)

__all__ = [
    "Each",
    "Lanes",
    "LanesMet",
    "OfLanes",
    "Parted",
    "contiguous",
    "each_call",
    "each_lane",
    "filled_like",
    "first_axis_innermost",
    "lane",
    "like_others",
    "numbers",
    "one_of",
    "restacked",
]
