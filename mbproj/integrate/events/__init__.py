"""Events in time: when functions of time begin, end or have a kink. Steps end there, in every formulation."""
