"""The search for the cheapest setting that keeps an error below a goal."""
