"""The bytes of a results file: opened, looked over and read here and nowhere else: a file may come from anybody.

Nothing outside this folder touches h5py for reading; `Contents` is what the rest of `results` works with.
"""
