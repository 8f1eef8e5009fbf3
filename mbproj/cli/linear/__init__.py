"""Commands on equilibria, modes and linear models, one module for each command."""
