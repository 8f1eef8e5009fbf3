"""Steppers: Runge-Kutta methods. A new one is a tableau, a file in `tableaus`, or in `implicit_tableaus`."""
