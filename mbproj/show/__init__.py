"""Pictures and pages of results: the only place that draws."""
