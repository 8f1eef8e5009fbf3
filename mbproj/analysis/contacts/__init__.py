"""What the stops and the dry frictions of a run have done."""
