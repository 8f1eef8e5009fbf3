"""The schema of reports: what each command with --json says, each fact with its key, type, unit and words."""
