"""Commands for designers: `curve`, `fit`, `optimise`, `sensitivity`."""
