"""Steppers: Runge-Kutta methods. A new method is a tableau: a file in `tableaus`, or in `implicit_tableaus`."""
