"""What every study measures with: a mechanism, a setting, a solution, a reference, errors, times."""
