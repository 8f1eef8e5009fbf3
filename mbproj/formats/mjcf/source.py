"""The source of an MJCF model for MuJoCo's compiler: mbproj reads includes, and removes assets that are missing."""

from __future__ import annotations

import math
from collections.abc import Iterator
from pathlib import Path
from xml.sax.saxutils import escape, quoteattr

from mbproj.base.dataclass import dataclass
from mbproj.base.errors import InputError, Place, Problem
from mbproj.base.text import plain_number
from mbproj.formats.geometry import LARGEST
from mbproj.formats.xml import Includes, XmlElement, inside, is_missing

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
    paths: dict[str, Path] = {}
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
            asset_folder = settings.get("meshdir", assets) if asset.tag == "mesh" else assets
            path = folder / asset_folder / (Path(file).name if strip else file)
            why = _read_mesh(files, folder, path, asset)
            if why:
                gone[asset.tag].add(name)
                element.children.remove(asset)
                missing.append((f"{asset.tag} '{name}'", asset.place, f"its file '{file}' {why}"))
            else:
                asset.attributes["name"] = name
                if not {"refpos", "refquat"} & asset.attributes.keys():
                    paths[name] = path.resolve()
    for compiler in root.all("compiler"):
        for key in FOLDERS:
            compiler.attributes.pop(key, None)
    for element in root.walk():
        for kind, names in gone.items():
            if element.get(kind) in names and element.tag in ("geom", "site"):
                element.attributes.pop(kind)
                element.attributes |= {"type": "sphere", "size": "0.01"}
                stand_ins.append(element)
    return paths, missing, stand_ins


def _read_mesh(files: dict[str, bytes], folder: Path, path: Path, asset: XmlElement) -> str:
    """Add the bytes of a mesh to `files`, and return ""; or the reason why that is not possible. Each file gets a new
    name, since MuJoCo takes two files of one name in different folders for the same."""
    if asset.tag == "hfield":
        return "is a height field, which takes no part"
    try:
        file = path.resolve()
        if not file.is_relative_to(folder):
            return "is outside of the model's folder"
        if not file.is_file():
            return "is not there"
        if file.stat().st_size > MOST_MESH_BYTES:
            return f"is larger than {MOST_MESH_BYTES // 1_000_000} MB"
        asset.attributes["file"] = f"{len(files)}{file.suffix}"
        files[asset.get("file")] = file.read_bytes()
    except (OSError, ValueError, RuntimeError):
        return "cannot be read"
    return ""


#: Assets without effect on the motion; attributes of the same names refer to them.
SHOWN_ONLY = ("texture", "skin")
#: The attributes that must not be negative, and the elements that have them.
POSITIVE, HELD = ("stiffness", "damping", "frictionloss"), ("joint", "freejoint", "tendon", "fixed", "spatial")
#: Attributes that are names or texts, even where they look like numbers.
NAMING = ("name", "class", "childclass", "file", "model", "data")


@dataclass(eq=False)
class MjcfSource:
    """A complete model: its root, and the bytes of its meshes by the name that MuJoCo has for the file. `files` are the
    paths of meshes by name, `missing` the missing assets, `stand_ins` the geoms in their place. `gone` are missing
    parts that may affect the motion: included files, flexible bodies."""

    root: XmlElement
    meshes: dict[str, bytes]
    files: dict[str, Path]
    missing: list[Missing]
    stand_ins: list[XmlElement]
    gone: list[Missing]
    includes: Includes

    def text(self) -> tuple[str, list[Place]]:
        """The XML text with one tag on each line, and the place from which each line comes."""
        lines: list[str] = []
        places: list[Place] = []
        for line, place in _tags(self.root):
            lines.append(line)
            places.append(place)
        return "\n".join(lines), places


def source_of(
    root: XmlElement, path: Path, outer: MjcfSource | None = None, above: tuple[Path, ...] = ()
) -> MjcfSource:
    """The source of a model with its includes. `outer` and `above` are the models that attach it, the next one and the
    files of all. Raises InputError at a file
    outside of its folder or in a circle, and at numbers that are not finite."""
    folder, above = path.resolve().parent, (*above, path.resolve())
    meshes, includes = (outer.meshes, outer.includes) if outer else ({}, Includes())
    source = MjcfSource(root, meshes, {}, [], [], [], includes)
    source.root = _included(source, root, folder, above)
    _refuse_infinite(source.root)
    _refuse_negative(source.root)
    _without_pictures(source.root)
    _without_passive(source.root)
    _without_flexible(source)
    source.files, source.missing, source.stand_ins = take_meshes(source.root, source.meshes, folder)
    _attach(source, folder, above)
    return source


def _tags(element: XmlElement) -> Iterator[tuple[str, Place]]:
    attributes = "".join(f" {name}={quoteattr(value)}" for name, value in element.attributes.items())
    flat = f"<{element.tag}{attributes}".replace("\n", " ")
    if not element.children and not element.text:
        yield f"{flat}/>", element.place
        return
    yield f"{flat}>{escape(' '.join(element.text.split()))}", element.place
    for child in element.children:
        yield from _tags(child)
    yield f"</{element.tag}>", element.place


def _included(source: MjcfSource, element: XmlElement, folder: Path, above: tuple[Path, ...]) -> XmlElement:
    """The element with the contents of included files in the place of each <include>. Files are named from the main
    model's folder; missing ones are noted in the source."""
    children: list[XmlElement] = []
    for child in element.children:
        if child.tag != "include":
            children.append(_included(source, child, folder, above))
            continue
        if child.get("file") and is_missing(child.get("file"), folder, folder):
            source.gone.append((f"include of '{child.get('file')}'", child.place, "its file is not there"))
            continue
        file = inside(child.get("file"), child.place, folder, folder)
        inner = source.includes.read(file, child.place, above, child.get("file"))
        children += _included(source, inner, folder, (*above, file)).children
    return XmlElement(element.tag, dict(element.attributes), element.place, children, element.text)


def _refuse_infinite(root: XmlElement) -> None:
    """Raises InputError at numbers that are not finite, too large, or not there, which MuJoCo accepts. A name may look
    like one, and a range may have no end."""
    names = {element.get("name") for element in root.walk()}
    problems = []
    for element in root.walk():
        for key, value in element.attributes.items():
            largest = math.inf if key.endswith("range") else LARGEST
            if key not in NAMING and value not in names and any(_is_beyond(part, largest) for part in value.split()):
                what = f"'{key}' of <{element.tag}> is not finite, or beyond {LARGEST:g}"
                problems.append(Problem(what, element.place, "write numbers as in '0 0 1'"))
            elif key == "anchor" and not value.strip():  # on which MuJoCo keeps its lock: the next import never ends
                problems.append(Problem(f"'anchor' of <{element.tag}> is empty", element.place, "give a point"))
    if problems:
        raise InputError(problems)


def _is_beyond(text: str, largest: float) -> bool:
    number = _number(text)
    return number is not None and not (math.isfinite(number) and abs(number) <= largest)


def _number(text: str) -> float | None:
    try:
        return plain_number(text)
    except ValueError:
        return None


def _refuse_negative(root: XmlElement) -> None:
    """Raises InputError at negative springs, dampers and dry friction, which would add energy; MuJoCo accepts them."""
    problems = []
    for element in root.walk():
        for key in POSITIVE if element.tag in HELD else ():
            first = _number((element.get(key).split() or [""])[0])
            if first is not None and first < 0.0:
                what = f"'{key}' of <{element.tag}> is negative"
                problems.append(Problem(what, element.place, "give 0 or more"))
    if problems:
        raise InputError(problems)


def _without_pictures(root: XmlElement) -> None:
    """Remove textures and skins: they have no effect on the motion, and their files are usually missing."""
    for element in root.walk():
        element.children = [child for child in element.children if child.tag not in SHOWN_ONLY]
        if element.tag == "material":
            element.attributes.pop("texture", None)
            element.children = []


def _without_passive(root: XmlElement) -> None:
    """Write the flag `passive` of older versions of MuJoCo as those of its two parts, which have taken its place."""
    for option in root.all("option"):
        for flag in option.all("flag"):
            value = flag.attributes.pop("passive", None)
            if value is not None:
                flag.attributes = {"spring": value, "damper": value} | flag.attributes


def _without_flexible(source: MjcfSource) -> None:
    for element in source.root.walk():
        for child in element.all("flexcomp"):
            element.children.remove(child)
            source.gone.append((f"flexcomp '{child.get('name')}'", child.place, "a scene has no flexible bodies"))


def _attach(source: MjcfSource, folder: Path, above: tuple[Path, ...]) -> None:
    """Read the models to which <attach> refers. Raises InputError at one that is outside of the folder, in a circle, or
    whose own meshes are missing."""
    for asset in [each for section in source.root.all("asset") for each in section.all("model")]:
        file = inside(asset.get("file"), asset.place, folder, folder)
        inner = source_of(source.includes.read(file, asset.place, above, asset.get("file")), file, source, above)
        if inner.stand_ins:
            what, place, why = inner.missing[0]
            raise InputError(Problem(f"the {what}: {why}", place, "put it there: another model attaches this one"))
        source.missing += inner.missing
        source.gone += inner.gone
        asset.attributes["file"] = f"{len(source.meshes)}.xml"
        source.meshes[asset.get("file")] = inner.text()[0].encode()
