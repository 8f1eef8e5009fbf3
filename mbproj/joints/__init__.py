"""Joint types as data: `JOINTS` by name."""

from mbproj.joints.table import COORDINATE_UNITS, INERTIA_UNITS, JOINTS, JointType, Parameter

__all__ = ["COORDINATE_UNITS", "INERTIA_UNITS", "JOINTS", "JointType", "Parameter"]
