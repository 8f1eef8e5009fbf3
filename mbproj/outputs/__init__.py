"""Files that commands write: each is new and private until it is whole, and replaces nothing but its own kind."""

from mbproj.outputs.csv_table import write_csv
from mbproj.outputs.kinds import JUNIT, PAGE, SCENE, SCENE_SCHEMA, Kind, csv, film, hdf5, picture
from mbproj.outputs.replace import check_replaceable, make_folder, replacing, write_text

__all__ = [
    "JUNIT",
    "PAGE",
    "SCENE",
    "SCENE_SCHEMA",
    "Kind",
    "check_replaceable",
    "csv",
    "film",
    "hdf5",
    "make_folder",
    "picture",
    "replacing",
    "write_csv",
    "write_text",
]
