"""The cheapest setting that keeps an error."""
