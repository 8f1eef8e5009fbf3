"""Planar scenes: where the joints alone keep every body in a plane, three coordinates a body are enough.

    plane = planar_reduction(system, q)                 # Plane | NotPlanar, at an assembled pose
    p, u = plane.reduce(q, v)                           # (..., 7n) -> (..., 3n)
    q, v, acceleration = plane.expand(p, u, u_dot)      # and back

Rows that act in the plane stay, as they are, on 2-vectors. Rows that hold the bodies in the plane are left out,
together with the motions out of it. Of the inertia only J_nn = nᵀJn is left, whatever the products of inertia.

The equations of motion in the plane are rows of M q'' + Cᵀλ = Q. The accelerations out of the plane do not appear in
them, because the joints forbid them. The multipliers of the rows that hold the bodies do not appear, because those rows
have no gradient in the plane. The gyroscopic torque ω × Jω has no component along n, because ω is along n. Products of
inertia, and forces along n, load the joints only.
"""
