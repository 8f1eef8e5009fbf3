"""The point of contact of a joint that rolls on a plane: no body carries this point along."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from mbproj.arrays import Array
from mbproj.constraints import PRIMITIVES
from mbproj.constraints.slip import Slip
from mbproj.joints import JOINTS
from mbproj.model.compile.frames import SYMBOLS
from mbproj.model.compile.joint_rows import primitive_of
from mbproj.scene.records import Joint

#: The primitive whose point of contact is that of a wheel. A joint that rolls along a line has no row of slip, but
#: touches its plane as a wheel does.
WHEEL = "wheel_slip_along"


def place_of_contact(joint: Joint) -> Callable[[Array], Array] | None:
    """Return a function from the joint's symbols (T, 8, 3) to its points of contact (T, 3), all global. None for a
    joint that does not roll."""
    kinds = [row[0] for row in JOINTS[joint.type].rows]
    slips = [kind for kind in kinds if issubclass(PRIMITIVES[kind], Slip)]
    if not slips and not JOINTS[joint.type].is_on_plane:
        return None
    slip = primitive_of((slips[0] if slips else WHEEL,), joint)
    assert isinstance(slip, Slip)

    def place(symbols: Array) -> Array:
        arm, _ = slip.contact(symbols)
        return np.asarray(symbols[:, SYMBOLS.index("p2")] + arm, dtype=float)

    return place
