"""Files of modes and of linear models, each a table of parts that is written and read whole."""
