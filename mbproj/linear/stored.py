"""Modes as their file stores them: for the bodies of the scene, where the computation has carriers."""

from __future__ import annotations

import numpy as np

from mbproj.arrays import Array, Numbers
from mbproj.dynamics.equations.kinematics import attached
from mbproj.linear.mode_notes import notes_on
from mbproj.linear.modes import Modes
from mbproj.linear.root_loci import RootLocus
from mbproj.model.euler_parameters import product
from mbproj.results.linear.modes_file import StoredModes


def stored(modes: Modes, title: str, trace: RootLocus | None = None) -> StoredModes:
    """Return the content of `modes.h5`."""
    system, motion, names = modes.reference.system, modes.reference.motion, modes.reference.system.names
    pose = motion.pose
    return StoredModes(
        bodies=names.bodies,
        position=attached(pose, system.body_carrier, system.body_offset, np.ones(len(names.bodies))),
        orientation=product(pose.orientation[system.body_carrier], system.body_turn),
        coordinates=names.coordinates,
        coordinate_units=names.coordinate_units,
        coordinate=motion.expected,
        names=[modes.name(mode) for mode in range(len(modes.eigenvalues))],
        eigenvalue=modes.eigenvalues,
        frequency=modes.frequencies,
        damping_ratio=modes.damping_ratios,
        displacement=_of_bodies(modes),
        coordinate_shape=modes.coordinates,
        states=names.states,
        state_units=names.state_units,
        state_shape=modes.states,
        state_share=modes.state_share,
        kinetic_names=modes.kinetic_names,
        kinetic_share=modes.kinetic,
        strain_names=modes.strain_names,
        strain_share=modes.strain,
        varied=() if trace is None else (trace.name,),
        trace_value=np.zeros(0) if trace is None else trace.values,
        trace=np.zeros((0, 0), dtype=complex) if trace is None else trace.eigenvalues,
        where=modes.reference.where,
        time=motion.t,
        title=title,
        notes="\n".join(notes_on(modes)),
    )


def _of_bodies(modes: Modes) -> Numbers:
    """Shifts and turns of the scene's bodies, (k, N, 6)."""
    system, pose = modes.reference.system, modes.reference.motion.pose
    carried = modes.shapes[:, system.body_carrier]
    arm: Array = (pose.rotation[system.body_carrier] @ system.body_offset[..., None])[..., 0]
    shift = carried[..., :3] + np.cross(carried[..., 3:], arm)
    return np.concatenate([shift, carried[..., 3:]], axis=-1)
