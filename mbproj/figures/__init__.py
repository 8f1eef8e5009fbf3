"""Pictures of results: the only package that imports matplotlib. `kinds.draw` draws what `mbproj plot` shows, `pages`
draws what studies show, `save` writes both."""
