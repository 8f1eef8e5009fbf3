"""Pictures of results, the only package that imports matplotlib: `kinds.KINDS` by name, `draw`, `save`."""
