"""The version of mbproj, which stands only here."""

__version__ = "0.1.0"
