"""Time events: the times at which functions of time begin, end or have a kink. Steps end there, in every
formulation."""
