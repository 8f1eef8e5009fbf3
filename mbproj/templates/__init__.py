"""Scene files to begin with, written by `mbproj new`: readable, commented, and with what they expect of their run."""

from mbproj.templates.registry import OPTIONS, TEMPLATES, Template, written

__all__ = ["OPTIONS", "TEMPLATES", "Template", "written"]
