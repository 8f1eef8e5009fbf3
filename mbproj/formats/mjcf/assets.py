"""Meshes of an MJCF model: the bytes of those whose files exist, and spheres in the place of those that are missing."""

from __future__ import annotations

from pathlib import Path

from mbproj.errors import Place
from mbproj.formats.xml import XmlElement

#: The most bytes of a mesh that is read.
MOST_MESH_BYTES = 64_000_000
#: The attributes with the folders of files. They are removed, since MuJoCo gets the bytes of the files.
FOLDERS = ("assetdir", "meshdir", "texturedir", "strippath")

#: A missing asset: its name in messages, its place, and the reason.
Missing = tuple[str, Place, str]


def take_meshes(
    root: XmlElement, files: dict[str, bytes], folder: Path
) -> tuple[dict[str, Path], list[Missing], list[XmlElement]]:
    """Add the bytes of the meshes to `files`. Return the paths of the meshes by name, the missing assets, and the geoms
    that stand for these: spheres, whose mass must not count."""
    missing: list[Missing] = []
    found: dict[str, Path] = {}
    stand_ins: list[XmlElement] = []
    settings = {name: value for each in root.all("compiler") for name, value in each.attributes.items()}
    assets = settings.get("assetdir", "")
    strip = settings.get("strippath", "false") == "true"
    gone: dict[str, set[str]] = {"mesh": set(), "hfield": set()}
    for element in root.walk():
        for asset in [child for child in element.children if element.tag == "asset" and child.tag in gone]:
            file = asset.get("file")
            name = asset.get("name") or Path(file).stem
            if not file:
                continue
            own = settings.get("meshdir", assets) if asset.tag == "mesh" else assets
            path = folder / own / (Path(file).name if strip else file)
            why = _read_mesh(files, folder, path, asset)
            if why:
                gone[asset.tag].add(name)
                element.children.remove(asset)
                missing.append((f"{asset.tag} '{name}'", asset.place, f"its file '{file}' {why}"))
            else:
                asset.attributes["name"] = name
                if not {"refpos", "refquat"} & asset.attributes.keys():
                    found[name] = path.resolve()
    for compiler in root.all("compiler"):
        for key in FOLDERS:
            compiler.attributes.pop(key, None)
    for element in root.walk():
        for kind, names in gone.items():
            if element.get(kind) in names and element.tag in ("geom", "site"):
                element.attributes.pop(kind)
                element.attributes |= {"type": "sphere", "size": "0.01"}
                stand_ins.append(element)
    return found, missing, stand_ins


def _read_mesh(files: dict[str, bytes], folder: Path, path: Path, asset: XmlElement) -> str:
    """Add the bytes of a mesh to `files`, and return ""; or the reason why that is not possible. Each file gets a new
    name, since MuJoCo takes two files of one name in different folders for the same."""
    if asset.tag == "hfield":
        return "is a height field, which takes no part"
    try:
        found = path.resolve()
        if not found.is_relative_to(folder):
            return "is outside of the model's folder"
        if not found.is_file():
            return "is not there"
        if found.stat().st_size > MOST_MESH_BYTES:
            return f"is larger than {MOST_MESH_BYTES // 1_000_000} MB"
        asset.attributes["file"] = f"{len(files)}{found.suffix}"
        files[asset.get("file")] = found.read_bytes()
    except (OSError, ValueError, RuntimeError):
        return "cannot be read"
    return ""
