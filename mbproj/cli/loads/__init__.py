"""What a run says of its loads: the largest ones, and how long they last."""
