"""Joint types as data: `JOINTS` by name."""

from mbproj.joints.joint_type import JointType, Parameter
from mbproj.joints.table import COORDINATE_UNITS, INERTIA_UNITS, JOINTS

__all__ = ["COORDINATE_UNITS", "INERTIA_UNITS", "JOINTS", "JointType", "Parameter"]
