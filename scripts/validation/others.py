"""The IFToMM library of benchmark problems, and the Test Set for Initial Value Problem Solvers."""

from __future__ import annotations

from .case import Case
from .readable import LETTERS

IFTOMM = "IFToMM library of computational benchmark problems"
#: The squeezer's angles are those of joints in a tree of its bodies; the source's are sums, see `reference_table`.
TREE = {
    "K1.ground": "A",
    "K2.K1": "B",
    "K3.ground": "D",
    "K4.K3": "E",
    "K5.ground": "G",
    "K6.K3": "H",
    "K7.ground": "J",
}
SQUEEZER = {
    **{bodies: f"{joint}.angle" for bodies, joint in TREE.items()},
    **{f"K{k}.speed": f"K{k}.angular_velocity.z" for k in range(1, 8)},
    **{f"K{k}.acceleration": f"K{k}.angular_acceleration.z" for k in range(1, 8)},
}


def n_four_bar(n: int, short: float = 0.5, **quick: str) -> Case:
    """Problem A02 with n loops."""
    return Case(
        name=f"iftomm_n_four_bar_{n}",
        title=f"N-four-bar with N = {n} (IFToMM A02)",
        source=f"iftomm/A02_N{n}",
        origin="the exact equation at 1e-13; MSC Adams' solution for N = 40 (IFToMM library, A02) agrees to 1.5e-6",
        notes=(
            f"Problem A02 of the {IFTOMM}: {n + 1} bars on the ground, coupled by {n} at their tops into "
            "parallelograms. Twice a turn all bars lie on one line, where every loop could go on crossed as well, and "
            "the rows of C_q become dependent. With φ from the vertical, φ(0) = 0 and φ'(0) = 1 rad/s, the exact "
            "equation is φ'' = g ((N + 1)/2 + N) / ((N + 1)/3 + N) sin φ. In space the revolutes of a loop hold its "
            "plane three times over. Compared over 10 s: the top of the first bar."
        ),
        columns={"x_B0": "B0.position.x", "y_B0": "B0.position.y"},
        simulation={
            "duration": "10 s",
            "tolerance": "1.0e-11" if n < 40 else "1.0e-10",
            "integrator": "dop853",
            "output_step": "50 ms",
        },
        tolerances={"position": 2e-8},
        grid=0.05,
        short=short,
        quick=quick,
        loops=LETTERS[n + 2 : 3 * n + 2 : 2],  # after those on the ground, the second of each coupler
        markers={"B0": ("v0", (0.0, 0.5, 0.0))},
    )


OTHERS = (
    Case(
        name="iftomm_pendulum",
        title="Simple pendulum over 2000 s (IFToMM A01)",
        source="iftomm/A01",
        origin=f"MSC Adams, as published in the {IFTOMM} (A01); the exact solution agrees to 7e-7",
        notes=(
            f"Problem A01 of the {IFTOMM}: a point mass on a massless rod of 1 m, released from the horizontal. "
            "Moments of 1e-13 stand for the point's zero: 1e-9 would make it late by a microsecond at the end. "
            "Compared over 2000 s, 845 periods."
        ),
        columns={"x": "p.position.x", "y": "p.position.y"},
        simulation={"duration": "2000 s", "tolerance": "1.0e-13", "integrator": "dop853", "output_step": "0.5 s"},
        tolerances={"position": 7.1e-7},
        moments=1e-13,
        grid=0.5,
        short=1.0,
    ),
    Case(
        name="iftomm_slider_crank",
        title="Spatial slider-crank (IFToMM)",
        source="iftomm/slidercrank_masoudi",
        origin=f"Masoudi et al., solution in the {IFTOMM}",
        notes=(
            f"The spatial slider-crank of the {IFTOMM}, with the parameters that its solution was computed with: the "
            "crank's mass in its middle, and the rod's 0.0004 kg m^2 about the axis normal to the rod and the pin. "
            "Compared over 5 s: the slider's place and the crank's angle."
        ),
        columns={"s": "slider.position.x", "theta": "A.angle"},
        simulation={"duration": "5 s", "tolerance": "1.0e-9", "integrator": "dop853", "output_step": "5/299"},
        tolerances={"position": 1.31e-5},
        relative={"angle": 1e-3},
        grid=5 / 299,
        short=0.3,
    ),
    Case(
        name="andrews_squeezer",
        title="Andrews' squeezer (Test Set for IVP Solvers)",
        source="ivp_testset/andrews",
        origin="PSIDE at 1e-14, 14 digits: Test Set for IVP Solvers (CWI/Bari), Andrews' squeezing mechanism",
        notes=(
            "Andrews' squeezing mechanism (Schiehlen, Multibody Systems Handbook, 1990; Hairer & Wanner, Solving "
            "Ordinary Differential Equations II, ch. VII.7): seven bodies in a plane, driven by a constant torque "
            "on K1 against a spring. Ten revolutes close three loops: in space nine of 50 joint rows are redundant, "
            "so that it takes planar coordinates. Where C, F and I are point_on_line along z the motion is the "
            "same, and no row is redundant. Compared at 0.03 s, when K1 has turned two and a half times: angles, "
            "speeds and accelerations. The source's errors are those of an equation of index 3: 1e-10 of the "
            "angles, 1e-8 of the speeds, 1e-6 of the accelerations."
        ),
        columns=SQUEEZER,
        simulation={"duration": "30 ms", "tolerance": "1.0e-12", "integrator": "dop853", "output_step": "10 ms"},
        tolerances={"angle": 2e-9},
        relative={"angular_velocity": 1e-7, "angular_acceleration": 1e-5},
        grid=0.03,
        short=0.03,
        quick={"tolerance": "1.0e-10"},
        loops=("C", "F", "I"),
    ),
    n_four_bar(1),
    n_four_bar(2),
    n_four_bar(40, short=0.05, integrator="dop853", step="25 ms"),
)
