"""A scene seen from elsewhere, in other units, numbered otherwise, or with one quantity changed: each a new scene."""
