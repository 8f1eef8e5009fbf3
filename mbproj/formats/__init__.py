"""Models in other formats, MJCF, URDF and SDF, as scenes, and scenes as models of these formats."""
