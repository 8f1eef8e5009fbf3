"""Joint types as data: `JOINTS` by name."""

from mbproj.joints.joint_type import JointType, Parameter
from mbproj.joints.table import COORDINATE_UNITS, INERTIA_UNITS, JOINTS
from mbproj.registry import lazily

__all__ = ["COORDINATE_UNITS", "INERTIA_UNITS", "JOINTS", "JointType", "Parameter"]

__getattr__ = lazily(
    __name__,
    {
        "joint_type": "geneva mesh thread",
        "table": "TWO_ANGLES",
    },
)
