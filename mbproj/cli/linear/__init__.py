"""Commands on equilibria, modes and linear models, one module a command."""
