"""Pages of figures for the studies and for `mbproj paper`, one module each: arrays in, a Figure out."""
