"""Runge-Kutta methods: a method is a tableau, a file of `tableaus` or of `implicit_tableaus`."""
