"""The source of an MJCF model for MuJoCo's compiler: includes read by us, assets that are missing stripped and said."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from xml.sax.saxutils import escape, quoteattr

from mbproj.dataclass import dataclass
from mbproj.errors import Place
from mbproj.formats.included import include, inside, is_missing
from mbproj.formats.xml import Element

#: A mesh is read up to so many bytes.
MOST_MESH_BYTES = 64_000_000
#: Assets that have no say in the motion, and the attributes that name them.
SHOWN_ONLY = ("texture", "skin")
#: Where files are, which MuJoCo need not know.
FOLDERS = ("assetdir", "meshdir", "texturedir", "strippath")


@dataclass(eq=False)
class Source:
    """A model that stands on its own: its root, the bytes of its meshes by file, what is missing, and the geoms that
    stand for what is missing. `gone` are included files that are not there."""

    root: Element
    meshes: dict[str, bytes]
    missing: list[tuple[str, Place, str]]
    stand_ins: list[Element]
    gone: list[tuple[str, Place]]

    def text(self) -> tuple[str, list[Place]]:
        """XML with one tag a line, and where each of its lines comes from."""
        lines: list[str] = []
        places: list[Place] = []
        for line, place in _tags(self.root):
            lines.append(line)
            places.append(place)
        return "\n".join(lines), places


def source_of(root: Element, path: Path) -> Source:
    """The model with its includes. Raises InputError at one that is outside of the folder, or in a circle."""
    folder = path.resolve().parent
    source = Source(root, {}, [], [], [])
    whole = _included(source, root, folder, (path.resolve(),))
    source.root = whole
    _without_pictures(whole)
    _take_meshes(source, folder)
    return source


def _tags(element: Element) -> Iterator[tuple[str, Place]]:
    attributes = "".join(f" {name}={quoteattr(value)}" for name, value in element.attributes.items())
    flat = f"<{element.tag}{attributes}".replace("\n", " ")
    if not element.children and not element.text:
        yield f"{flat}/>", element.place
        return
    yield f"{flat}>{escape(' '.join(element.text.split()))}", element.place
    for child in element.children:
        yield from _tags(child)
    yield f"</{element.tag}>", element.place


def _included(source: Source, element: Element, folder: Path, above: tuple[Path, ...]) -> Element:
    """The element with what <include> brings in its place; files are named from the main model's folder. Those that are
    missing are noted in the source."""
    children: list[Element] = []
    for child in element.children:
        if child.tag != "include":
            children.append(_included(source, child, folder, above))
            continue
        if child.get("file") and is_missing(child.get("file"), folder, folder):
            source.gone.append((child.get("file"), child.place))
            continue
        file = inside(child.get("file"), child.place, folder, folder)
        inner = include(file, child.place, above, str(Path(child.place.file).parent / child.get("file")))
        children += _included(source, inner, folder, (*above, file)).children
    return Element(element.tag, dict(element.attributes), element.place, children, element.text)


def _without_pictures(root: Element) -> None:
    """Takes out textures and skins: they have no say in the motion, and most of the time their files are missing."""
    for element in root.walk():
        element.children = [child for child in element.children if child.tag not in SHOWN_ONLY]
        if element.tag == "material":
            element.attributes.pop("texture", None)
            element.children = []


def _take_meshes(source: Source, folder: Path) -> None:
    """Reads the meshes that are there; geoms of the others become spheres, whose mass must not count."""
    settings = {name: value for each in source.root.all("compiler") for name, value in each.attributes.items()}
    assets = settings.get("assetdir", "")
    strip = settings.get("strippath", "false") == "true"
    gone: dict[str, set[str]] = {"mesh": set(), "hfield": set()}
    for element in source.root.walk():
        for asset in [child for child in element.children if element.tag == "asset" and child.tag in gone]:
            file = asset.get("file")
            name = asset.get("name") or Path(file).stem
            if not file:
                continue
            own = settings.get("meshdir", assets) if asset.tag == "mesh" else assets
            why = _read_mesh(source, folder, own, file, strip, asset)
            if why:
                gone[asset.tag].add(name)
                element.children.remove(asset)
                source.missing.append((f"{asset.tag} '{name}'", asset.place, f"its file '{file}' {why}"))
            else:
                asset.attributes["name"] = name
    for compiler in source.root.all("compiler"):
        for key in FOLDERS:
            compiler.attributes.pop(key, None)
    for element in source.root.walk():
        for kind, names in gone.items():
            if element.get(kind) in names and element.tag in ("geom", "site"):
                element.attributes.pop(kind)
                element.attributes |= {"type": "sphere", "size": "0.01"}
                source.stand_ins.append(element)
        if element.tag in ("body", "worldbody"):
            element.children = [each for each in element.children if each.tag != "flex"]


def _read_mesh(source: Source, folder: Path, own: str, file: str, strip: bool, asset: Element) -> str:
    """Why a mesh's file cannot be had, "" where it is among the meshes now. Each file gets a name of its own: MuJoCo
    takes two of one name in different folders for one."""
    if asset.tag == "hfield":
        return "is a height field, which takes no part"
    name = Path(file).name if strip else file
    try:
        found = (folder / own / name).resolve()
        if not found.is_relative_to(folder):
            return "is outside of the model's folder"
        if not found.is_file():
            return "is not there"
        if found.stat().st_size > MOST_MESH_BYTES:
            return f"is larger than {MOST_MESH_BYTES // 1_000_000} MB"
        asset.attributes["file"] = f"{len(source.meshes)}{found.suffix}"
        source.meshes[asset.get("file")] = found.read_bytes()
    except (OSError, ValueError, RuntimeError):
        return "cannot be read"
    return ""
