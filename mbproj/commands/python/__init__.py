"""The commands as Python functions: `mbproj.run`, `mbproj.modes` and others take a scene in any form."""
