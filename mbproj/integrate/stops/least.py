"""The least-norm share of what rests on stops by friction, at samples: a run keeps any share within the cones."""

from __future__ import annotations

import numpy as np

from mbproj.arrays import Array
from mbproj.dynamics.contact.freedom import Freedom
from mbproj.dynamics.friction.problem import Cone, contact_problem
from mbproj.dynamics.observe.samples import Samples
from mbproj.integrate.stops.variants import Variant
from mbproj.model.frictions import Frictions
from mbproj.model.stops import Stops
from mbproj.thresholds import THRESHOLDS


def least_shares(
    variant: Variant, stops: Stops, frictions: Frictions, samples: Samples, press: Array, force: Array
) -> tuple[Array, Array]:
    """The pushes (T, S) and the forces of frictions (T, K), from those of any share; the same where there is one."""
    contacts = variant.contacts
    resting = np.flatnonzero(np.isin(frictions.stop, contacts.touching))
    resting = resting[[k not in contacts.sliding for k in resting.tolist()]]
    if len(resting) == 0 or len(contacts.touching) < 2:  # the forces at one point are unique
        return press, force
    touching = np.array(contacts.touching, dtype=np.intp)
    own = (len(touching) + np.flatnonzero(frictions.stop[resting] == stop) for stop in touching)
    cones = [Cone(at, tuple(rows.tolist()), _most(frictions, int(touching[at]))) for at, rows in enumerate(own)]
    press, force, B, known = press.copy(), force.copy(), np.zeros((0, 0)), b""
    for at in range(len(samples.t)):
        if known != samples.q[at].tobytes():
            known = samples.q[at].tobytes()
            freedom = Freedom.at(variant.free, samples.state(at))
            A = np.vstack([freedom.rows(stops)[touching], freedom.rows_of(frictions.coordinates)[resting]])
            B = A @ A.T
        borne = np.concatenate([press[at, touching], force[at, resting]])
        least = contact_problem(B, -B @ borne, cones)
        if least is not None:
            press[at, touching], force[at, resting] = least[: len(touching)], least[len(touching) :]
    return press, force


def _most(frictions: Frictions, stop: int) -> float:
    """The coefficient at rest of the friction of a stop, 0 for none, with what shares at the edge are off by."""
    return (1.0 + THRESHOLDS.slips) * float(frictions.static[frictions.stop == stop].max(initial=0.0))
