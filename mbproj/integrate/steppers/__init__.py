"""Steppers: Runge-Kutta methods. A new explicit one is a tableau, a file in `tableaus`; the coefficients of implicit
ones are in `implicit_tableaus`."""
