"""Linear equations in axes in which they are constant, on the tangent space, and without slip."""
