"""Commands that look for a design: `fit`, `optimise`, `sensitivity`."""
