"""What every other room may import: errors with places, the registry, plug-ins, thresholds, the version."""
