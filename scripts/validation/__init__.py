"""mbproj against what others computed: the cases, how they are converted, and how a run is held against them."""
