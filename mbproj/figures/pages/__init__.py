"""Pages of figures for the studies and for `mbproj paper`, one a module: arrays in, a Figure out."""
