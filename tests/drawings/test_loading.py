"""Assemblies from files of polygons: each form against the pattern that it was drawn from."""

from __future__ import annotations

import json
import pathlib
from typing import Any

import ezdxf
import ezdxf.units
import numpy as np
import pytest

import warprock as wr
from warprock.analysis.load_limit import collapse_load
from warprock.drawings.loading import load_drawing
from warprock.drawings.outline import MOST_OUTLINES
from warprock.errors import InputError
from warprock.model import patterns
from warprock.model.assembly import Assembly, Piece, assemble

ARCH = patterns.arch(5.0, 0.75, np.pi, 9)
FRICTION = 0.7


def write_dxf(path: pathlib.Path, pieces: list[Piece], unit: int, size: float) -> None:
    """Closed polylines on two layers, with names in the stones and a line that is no block."""
    drawing = ezdxf.new()
    drawing.units = unit
    space = drawing.modelspace()
    for piece in pieces:
        layer = "supports" if piece.fixed else "stones"
        corners = (size * piece.corners).tolist()
        space.add_lwpolyline(corners, close=True, dxfattribs={"layer": layer})
        middle = size * piece.corners.mean(axis=0)
        if not piece.fixed:
            space.add_text(f"V{piece.name}").set_placement(tuple(middle))
    space.add_line((0.0, 0.0), (1.0, 0.0))
    drawing.saveas(path)


def write_obj(path: pathlib.Path, pieces: list[Piece]) -> None:
    lines = []
    for piece in pieces:
        lines += [f"o {piece.name}", *(f"v {x!r} 0 {y!r}" for x, y in piece.corners.tolist())]
        lines.append("f " + " ".join(str(k) for k in range(-len(piece.corners), 0)))
    path.write_text("\n".join(lines), encoding="utf-8")


def mesh_of(piece: Piece, depth: float = 0.6, cut: bool = False) -> dict[str, Any]:
    """A prism as COMPAS keeps it, its ends as quadrilaterals or as two triangles each."""
    ends = [(x, y, z) for y in (0.0, depth) for x, z in piece.corners.tolist()]
    sides = [[k, (k + 1) % 4, 4 + (k + 1) % 4, 4 + k] for k in range(4)]
    faces = [[0, 1, 2], [0, 2, 3], [4, 5, 6], [4, 6, 7]] if cut else [[0, 1, 2, 3], [4, 5, 6, 7]]
    return {
        "vertex": {str(k): dict(zip("xyz", at, strict=True)) for k, at in enumerate(ends)},
        "face": {str(k): face for k, face in enumerate(faces + sides)},
    }


def write_compas(path: pathlib.Path, pieces: list[Piece], form: str) -> None:
    """An Assembly of compas_assembly and compas_cra, or a BlockModel of compas_dem."""
    if form == "Assembly":
        nodes = {
            str(k): {
                "block": {"dtype": "compas_assembly.datastructures/Block", "data": mesh_of(piece)},
                **({"is_support": True} if piece.fixed else {}),
            }
            for k, piece in enumerate(pieces)
        }
        data = {"graph": {"dtype": "compas.datastructures/Graph", "data": {"node": nodes}}}
    else:
        up = [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 2.0], [0.0, 0.0, 0.0, 1]]
        placed = {"dtype": "compas.geometry/Transformation", "data": {"matrix": up}}
        elements = {
            f"guid-{k}": {
                "dtype": "compas_dem.elements/Block",
                "data": {
                    "name": "Block",
                    "is_support": piece.fixed,
                    "geometry": {"data": mesh_of(piece, cut=True)},
                    "transformation": placed,
                },
            }
            for k, piece in enumerate(pieces)
        }
        data = {"elements": elements, "graph": {"node": {}}}
    path.write_text(json.dumps({"dtype": f"compas/{form}", "data": data}), encoding="utf-8")


def drawn(file: pathlib.Path, **more: Any) -> Assembly:
    """The assembly of a case with a drawing."""
    keys = {"pattern": "file", "file": str(file), "density": "2000 kg/m^3", **more}
    tables = {"contact": {"friction": FRICTION}, "run": {"duration": "1 s"}}
    found = wr.expand_lanes(wr.Case.from_dict({"assembly": keys, **tables}))
    return found.lanes.assembly.of(0)


def assert_same(found: Assembly, wanted: list[Piece], shift: float = 0.0) -> None:
    """The same blocks, joints and load factor as those of a pattern."""
    exact = assemble(wanted, depth=1.0, density=2000.0, friction=FRICTION)
    assert found.fixed.tolist() == exact.fixed.tolist()
    assert found.centre == pytest.approx(exact.centre + np.array([0.0, shift]), abs=1e-9)
    assert found.mass == pytest.approx(exact.mass, rel=1e-9)
    assert found.joints.blocks.tolist() == exact.joints.blocks.tolist()
    load = collapse_load(exact).load_factor
    assert collapse_load(found).load_factor == pytest.approx(load, rel=1e-6)


def test_a_drawing_says_its_unit_and_names_blocks(tmp_path: pathlib.Path):
    file = tmp_path / "arch.dxf"
    write_dxf(file, ARCH, ezdxf.units.MM, 1000.0)
    found = drawn(file, fixed=["supports"])
    assert_same(found, ARCH)
    assert found.names[:2] == ("V1", "V2")
    assert found.names[-2:] == ("supports 1", "supports 2")
    assert load_drawing(str(file)).left_out == "1 LINE"


def test_faces_are_blocks(tmp_path: pathlib.Path):
    file, pieces = tmp_path / "wall.obj", patterns.wall(0.4, 0.175, 5, 6, whole_first=False)
    write_obj(file, pieces)
    assert_same(drawn(file, fixed=["ground"], file_unit="1 m"), pieces)


@pytest.mark.parametrize(("form", "shift"), [("Assembly", 0.0), ("BlockModel", 2.0)])
def test_supports_of_compas_are_fixed(tmp_path: pathlib.Path, form: str, shift: float):
    file = tmp_path / "arch.json"
    write_compas(file, ARCH, form)
    assert_same(drawn(file, file_unit="1 m"), ARCH, shift)


def test_a_drawing_may_be_off_by_its_tolerance(tmp_path: pathlib.Path):
    """Corners off by a tenth of a millimetre, and one more corner on an edge: the same joints."""
    draw, file = np.random.default_rng(4), tmp_path / "arch.obj"
    moved = [
        piece._replace(corners=piece.corners + draw.uniform(-1e-4, 1e-4, piece.corners.shape))
        for piece in ARCH
    ]
    write_obj(file, moved)
    fixed = {"fixed": ["left abutment", "right abutment"], "file_unit": "1 m"}
    found = drawn(file, **fixed)
    exact = assemble(ARCH, depth=1.0, density=2000.0, friction=FRICTION)
    assert found.joints.blocks.tolist() == exact.joints.blocks.tolist()
    load = collapse_load(exact).load_factor
    # The error of a corner over the thickness, for each of the four hinges.
    assert collapse_load(found).load_factor == pytest.approx(load, abs=4e-4 / 0.75)
    with pytest.raises(InputError, match=r"keep blocks apart: .* overlap by 0\.0"):
        drawn(file, **fixed, joint_tolerance="0.01 mm")


def test_sizes_and_files_are_swept(tmp_path: pathlib.Path):
    names = []
    for thickness in (0.7, 0.8):
        names.append(f"arch-{thickness}.obj")
        write_obj(tmp_path / names[-1], patterns.arch(5.0, thickness, np.pi, 7))
    (tmp_path / "case.toml").write_text(
        f"""title = "Two drawings of arches, in two sizes"
source = "A test."
[assembly]
pattern = "file"
density = "2000 kg/m^3"
fixed = ["left abutment", "right abutment"]
[[sweep]]
assembly.file = {json.dumps(names)}
[[sweep]]
assembly.file_unit = ["0.5 m", "1 m"]
[contact]
friction = 0.7
[run]
duration = "1 s"
"""
    )
    table = wr.limit(wr.load_case(tmp_path), progress=False).table
    assert table["assembly_file"].astype(str).tolist() == [names[0]] * 2 + [names[1]] * 2
    assert table["file_unit_m"].tolist() == [0.5, 1.0] * 2
    loads = table["load_factor"].to_numpy()
    # A load factor has no size.
    assert loads[::2] == pytest.approx(loads[1::2], rel=1e-6)
    assert loads[2] > 1.2 * loads[0]


def write_text(path: pathlib.Path, text: str) -> pathlib.Path:
    path.write_text(text, encoding="utf-8")
    return path


SQUARE = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n"
TWO = (
    f"{SQUARE}v 0 {{0}} 0\nv 1 {{0}} 0\nv 1 2.5 0\nv 0 2.5 0\no base\nf 1 2 3 4\no top\nf 5 6 7 8\n"
)


@pytest.mark.parametrize(
    ("text", "more", "said"),
    [
        ("nothing", {}, "must hold faces (f) in one plane"),
        (f"{SQUARE}f 1 2 9\n", {}, "line 5: got 'f 1 2 9', must be v x y z, or f with"),
        (f"{SQUARE}v 3 2 1\nf 1 2 5\n", {}, "must be faces in one plane"),
        (TWO.format(1.0), {"file_unit": None}, "has none of its own"),
        (TWO.format(1.0), {"fixed": ["bases"]}, "did you mean base?"),
        (TWO.format(1.0), {"fixed": []}, "must name blocks or layers that do not move"),
        (TWO.format(1.5), {}, "the nearest is base, 500 mm away"),
        (TWO.format(1.003), {}, "base and top face each other over 3 mm"),
        (TWO.format(0.99), {}, "keep blocks apart: base and top overlap by 10 mm"),
        (TWO.format(1.0), {"file_unit": "1 mm"}, "have edges longer than 10 mm"),
        (TWO.format(1.0), {"fixed": ["top"]}, "block base hangs below all that touches it"),
        (SQUARE + "f 1 2 3 4\n" * (MOST_OUTLINES + 2), {}, "got more than 20,000 blocks"),
    ],
)  # fmt: skip
def test_what_cannot_be_used_is_refused_in_one_line(
    tmp_path: pathlib.Path, text: str, more: dict[str, Any], said: str
):
    file = write_text(tmp_path / "blocks.obj", text)
    keys = {"fixed": ["base"], "file_unit": "1 m", **more}
    with pytest.raises(InputError) as error:
        drawn(file, **{key: value for key, value in keys.items() if value is not None})
    assert said in str(error.value)
    assert "\n" not in str(error.value)


@pytest.mark.parametrize(
    ("name", "text", "said"),
    [
        ("a.dwg", "", "must end in .dxf, .json, .obj"),
        ("a.dxf", "hello", "must be a DXF file that ezdxf can read"),
        ("a.json", "{", "must be JSON: an Assembly or a BlockModel"),
        ("a.json", "{}", "got another structure, must hold an Assembly or a BlockModel"),
        ("a.json", "[]", "got nothing, must hold an Assembly"),
    ],
)
def test_files_of_another_form_are_refused(tmp_path: pathlib.Path, name: str, text: str, said: str):
    file = write_text(tmp_path / name, text)
    with pytest.raises(InputError) as error:
        drawn(file)
    assert said in str(error.value)
    with pytest.raises(InputError, match="must be a file to read") as missing:
        drawn(tmp_path / "no.obj")
    assert missing.value.key == "assembly.file"


def test_blocks_in_space_and_open_lines_are_refused(tmp_path: pathlib.Path):
    meshes = [mesh_of(ARCH[0]), mesh_of(ARCH[1], depth=2.0)]
    file = write_text(tmp_path / "a.json", json.dumps([{"data": each} for each in meshes]))
    with pytest.raises(InputError, match="must be prisms side by side in one plane"):
        load_drawing(str(file))
    drawing = ezdxf.new()
    drawing.modelspace().add_lwpolyline([(0.0, 0.0), (1.0, 0.0), (1.0, 1.0)])
    drawing.saveas(tmp_path / "open.dxf")
    with pytest.raises(InputError, match="got an open polyline, must be closed"):
        load_drawing(str(tmp_path / "open.dxf"))
    bent = ezdxf.new()
    bent.modelspace().add_lwpolyline(
        [(0.0, 0.0, 0.0), (1.0, 0.0, 0.5), (1.0, 1.0, 0.0)], format="xyb", close=True
    )
    bent.saveas(tmp_path / "bent.dxf")
    with pytest.raises(InputError, match="got a polyline with an arc, must have straight edges"):
        load_drawing(str(tmp_path / "bent.dxf"))


CUBE = """
v 0 0 0
v 1 0 0
v 1 1 0
v 0 1 0
v 0 0 1
v 1 0 1
v 1 1 1
v 0 1 1
o block
f 4 3 2 1
f 5 6 7 8
f 1 2 6 5
f 2 3 7 6
f 3 4 8 7
f 4 1 5 8
v 0 0 -1
v 3 0 -1
v 3 2 -1
v 0 2 -1
v 0 0 0
v 3 0 0
v 3 2 0
v 0 2 0
o ground
f 12 11 10 9
f 13 14 15 16
f 9 10 14 13
f 10 11 15 14
f 11 12 16 15
f 12 9 13 16
"""


def in_space(file: pathlib.Path, **more: object) -> wr.Case:
    assembly = {"pattern": "file", "file": str(file), "density": "2000 kg/m^3", **more}
    tables = {"contact": {"friction": 0.6}, "run": {"duration": "1 s"}}
    return wr.Case.from_dict({"model": "spatial", "assembly": assembly, **tables})


def test_bodies_of_obj_and_of_compas_are_blocks_in_space(tmp_path: pathlib.Path):
    file = tmp_path / "cube.obj"
    file.write_text(CUBE, encoding="utf-8")
    case = in_space(file, fixed=["ground"], file_unit="0.5 m")
    own = wr.expand_lanes(case).lanes.assembly.of(0)
    assert own.names == ("block", "ground")
    assert own.mass == pytest.approx([2000.0 * 0.125, 2000.0 * 0.75])
    assert own.joints.area == pytest.approx([0.25])
    meshes = load_drawing(str(file), in_space=True).solids
    nodes = {
        name: {"block": {"data": _mesh(each.corners)}, "is_support": name == "1"}
        for name, each in zip("01", meshes, strict=True)
    }
    file = tmp_path / "cube.json"
    file.write_text(json.dumps({"data": {"graph": {"data": {"node": nodes}}}}), encoding="utf-8")
    same = wr.expand_lanes(in_space(file, file_unit="0.5 m")).lanes.assembly.of(0)
    assert same.fixed.tolist() == [False, True]
    assert same.joints.area == pytest.approx([0.25])


def _mesh(corners: Any) -> dict[str, Any]:
    """The faces of a box whose corners stand in the order of `CUBE`."""
    faces = [[3, 2, 1, 0], [4, 5, 6, 7], [0, 1, 5, 4], [1, 2, 6, 5], [2, 3, 7, 6], [3, 0, 4, 7]]
    places = [dict(zip("xyz", map(float, at), strict=True)) for at in corners]
    return {
        "vertex": dict(zip("01234567", places, strict=True)),
        "face": {str(k): f for k, f in enumerate(faces)},
    }


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ("f 4 3 2 1\n", "", "block: got an open surface, must be closed"),
        ("v 1 1 1\n", "v .3 .3 .3\n", "block: got a body that is not convex, must be convex"),
        ("v 1 1 1\n", "v 1 nan 1\n", "must be at least 4 corners with finite coordinates"),
    ],
)
def test_bodies_that_are_open_or_not_convex_are_refused(
    tmp_path: pathlib.Path, old: str, new: str, said: str
):
    file = tmp_path / "cube.obj"
    file.write_text(CUBE.replace(old, new, 1), encoding="utf-8")
    with pytest.raises(wr.InputError, match=said):
        wr.expand_lanes(in_space(file, fixed=["ground"], file_unit="1 m"))
