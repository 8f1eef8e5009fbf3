"""What studies have computed, kept on disk by all that it follows from: one SQLite file of data in the user's folder
for caches. It may be deleted at any time; nothing in it is ever run as code."""

from mbproj.studies.store.value_cache import ValueCache, cached, key_of

__all__ = ["ValueCache", "cached", "key_of"]
