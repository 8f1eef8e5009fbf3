"""What a run's loads are: the largest ones, how long they last, how often they swing."""
