"""The scene file: YAML text becomes frozen records, whose every value knows its place."""
