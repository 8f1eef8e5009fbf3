"""The loads of a run: the largest ones, how long they last, how often they swing."""
