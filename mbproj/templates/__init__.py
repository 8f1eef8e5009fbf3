"""Scene files to begin with, written by `mbproj new`: readable, commented, and with expectations that a run checks."""

from mbproj.templates.registry import OPTIONS, TEMPLATES, Template, scene_text

__all__ = ["OPTIONS", "TEMPLATES", "Template", "scene_text"]
