"""The commands as functions: `mbproj.run`, `mbproj.modes` and others take a scene in any form and return an object."""
