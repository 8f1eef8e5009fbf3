"""Steppers: explicit Runge-Kutta methods. A new one is a tableau, a file in `tableaus`."""
