"""Maps of joints and meshes, in files of other programs: the same scenes as those written out, and what is refused."""

from __future__ import annotations

import re
import sys
from collections import Counter
from itertools import pairwise
from pathlib import Path
from typing import Any

import meshio
import numpy as np
import pytest
import shapely

from crackgrow import cli, solve
from crackgrow.case import Case, load_case
from crackgrow.case.mesh_file import ContentError, read_mesh
from crackgrow.errors import CaseError
from tests.joint_maps import case_text, joint_map
from tests.scenes import shipped_case
from tests.unit.case.scenes import CASES, blocks, changed, held, joint, load, rectangle, with_body

DXF = """0\nSECTION\n2\nENTITIES
0\nLINE\n8\njoints\n10\n1.0\n20\n1.0\n30\n5.0\n11\n3.0\n21\n2.0\n31\n5.0
0\nLWPOLYLINE\n8\nfaults\n90\n3\n70\n0\n10\n5.0\n20\n5.0\n10\n6.0\n20\n5.5\n10\n7.0\n20\n5.0
0\nENDSEC\n0\nEOF\n"""


def write_lines(file: Path, driver: str = "GPKG", layer: str | None = None, crs: str = "EPSG:3067") -> None:
    """Two features, the second one of two lines, with the attributes `set` and `n`."""
    import pyogrio

    shapes = shapely.from_wkt(["LINESTRING Z (1 1 7, 3 2 8)", "MULTILINESTRING ((5 5, 6 5), (7 7, 8 8))"])
    kind = "Unknown"
    if driver == "ESRI Shapefile":
        shapes = [shapely.MultiLineString(shapely.get_parts(shape).tolist()) for shape in shapely.force_2d(shapes)]
        kind = "MultiLineString"
    values = [np.array(["J1", "J2"], dtype=object), np.array([4, 5])]
    pyogrio.raw.write(
        file, shapely.to_wkb(shapes), values, np.array(["set", "n"], dtype=object),
        crs=crs, geometry_type=kind, driver=driver, layer=layer,
    )  # fmt: skip


def load_lines(folder: Path, shape: Any = None, **path: Any) -> Case:
    """A block of 10 m with the lines of a file as a set of cracks."""
    scene = {**with_body(shape or rectangle(0, 0, 10, 10)), "supports": "minimal"}
    scene["cracks"] = {"j": {"path": path, "contact": "none"}}
    scene["numerics"] = {"spacing": 1}
    return load(folder, scene)


@pytest.mark.parametrize(("name", "driver"), [("a.gpkg", "GPKG"), ("a.shp", "ESRI Shapefile")])
def test_lines_and_attributes_of_a_program_of_maps(name: str, driver: str, tmp_path: Path):
    write_lines(tmp_path / name, driver)
    case = load_lines(tmp_path, file=name)
    assert [crack.points.tolist() for crack in case.cracks] == [[[1, 1], [3, 2]], [[5, 5], [6, 5]], [[7, 7], [8, 8]]]
    chosen = load_lines(tmp_path, file=name, where={"set": "J2"}, names="n")
    assert [crack.name for crack in chosen.cracks] == ["j-5-1", "j-5-2"]


def test_lines_of_a_drawing(tmp_path: Path):
    (tmp_path / "a.dxf").write_text(DXF)
    case = load_lines(tmp_path, file="a.dxf", units="m")
    assert [crack.points.tolist() for crack in case.cracks] == [[[1, 1], [3, 2]], [[5, 5], [6, 5.5], [7, 5]]]
    (fault,) = load_lines(tmp_path, file="a.dxf", where={"Layer": "faults"}).cracks
    assert len(fault.points) == 3


@pytest.mark.parametrize(("path", "words"), [
    ({"file": "a.gpkg"}, "has several layers; `layer` says which: it has joints, faults"),
    ({"file": "a.gpkg", "layer": "joint"}, "has no layer 'joint'; it has joints, faults; did you mean 'joints'"),
    ({"file": "degrees.gpkg"}, r"is in degrees of longitude and latitude \(EPSG:4326\)"),
    ({"file": "none.gpkg"}, "cannot be read as|holds nothing"),
    ({"file": "none.shp"}, "cannot be read as|holds nothing"),
    ({"file": "none.dxf"}, "cannot be read as|holds nothing"),
])  # fmt: skip
def test_layers_degrees_and_files_that_are_none_are_told(path: dict[str, str], words: str, tmp_path: Path):
    write_lines(tmp_path / "a.gpkg", layer="joints")
    write_lines(tmp_path / "a.gpkg", layer="faults")
    write_lines(tmp_path / "degrees.gpkg", crs="EPSG:4326")
    for name in ("none.gpkg", "none.shp", "none.dxf"):
        (tmp_path / name).write_text("nothing")
    with pytest.raises(CaseError, match=words):
        load_lines(tmp_path, **path)
    assert len(load_lines(tmp_path, file="a.gpkg", layer="faults").cracks) == 3


def test_without_the_extra_it_is_named(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    write_lines(tmp_path / "a.gpkg")
    monkeypatch.setitem(sys.modules, "pyogrio", None)
    with pytest.raises(CaseError, match=r"needs pyogrio to be read: pip install 'crackgrow\[maps\]'"):
        load_lines(tmp_path, file="a.gpkg")


# --- whole maps ------------------------------------------------------------------------------------------------------


@pytest.mark.physics
@pytest.mark.parametrize(("n", "seed"), [*((50, k) for k in range(4)), (200, 0)])
def test_a_map_loads_and_is_brought_together(n: int, seed: int, tmp_path: Path, capsys: pytest.CaptureFixture[str]):
    """No tip is left within the tolerance of anything, and none of the joints that are well drawn is lost."""
    map_ = joint_map(n, seed)
    (map_.write(tmp_path) / "scene.yaml").write_text(case_text(map_))
    case = load_case(tmp_path / "scene.yaml")
    lines = [shapely.LineString(crack.points) for crack in case.cracks]
    rims = [shapely.LinearRing(ring.points) for ring in case.bodies[0].rings]
    tree = shapely.STRtree([*lines, *rims])
    for number, crack in enumerate(case.cracks):
        tips = shapely.points(crack.points[[0, -1]][[crack.tip_at_start, crack.tip_at_end]])
        near = tree.query(tips, predicate="dwithin", distance=0.999 * map_.tolerance)[1]
        assert set(near) <= {number}
    why = Counter(cut.why.split(" ")[0] for cut in case.cut)
    wanted = map_.defects
    assert why["has"] == wanted["no length"]
    assert why["runs"] >= wanted["twice"] + wanted["stacked"]
    rock = shapely.Polygon(case.bodies[0].outline).buffer(-2 * map_.tolerance)
    kept = shapely.union_all(lines).buffer(2.0 * map_.tolerance)
    lost = [
        shapely.LineString(points - case.origin).intersection(rock).difference(kept).length for points, _ in map_.traces
    ]
    assert max(lost) < 10.0 * map_.tolerance
    sets = {str(number): values["set"] for number, (_, values) in enumerate(map_.traces, 1)}
    for crack in case.cracks:
        assert crack.contact.friction == (0.4 if sets[crack.name.split("-")[1]] == "J2" else 0.7)
    if (n, seed) == (200, 0):
        assert cli.main(["check", str(tmp_path / "scene.yaml")]) == 0
        told = capsys.readouterr().out
        assert "these were moved: " in told
        assert "was left out of cracks, " in told


@pytest.mark.physics
def test_the_shipped_map_is_brought_together_and_told(capsys: pytest.CaptureFixture[str]):
    case = shipped_case("joint_map")
    assert (len(case.cracks), len({crack.name.split("-")[1] for crack in case.cracks})) == (43, 39)
    assert {crack.contact.friction for crack in case.cracks} == {0.4, 0.7}
    assert cli.main(["check", str(CASES / "joint_map.yaml")]) == 0
    told = capsys.readouterr().out
    assert "these were moved: the end of crack 'joints-3'" in told
    assert "all of 'joints-18' (feature 18)" in told


SIZE = 12  # cells of the block along x and y, one unit each; basalt above y = 7
HOLE = {(x, y) for x in (8, 9) for y in (3, 4)}  # cells that are left out
CURVES = {
    "bottom": [(x, 0) for x in range(SIZE + 1)],
    "top": [(x, SIZE) for x in range(SIZE + 1)],
    "flat": [(2, 5), (3, 5), (4, 5), (5, 5)],
    "kinked": [(2, 1), (3, 2), (4, 3), (5, 3)],
    "steep": [(7, 9), (7, 10), (7, 11)],
}


def block() -> meshio.Mesh:
    """A block of granite, meshed by triangles, under basalt, by quadrangles, with a hole and lines along cracks."""
    node = {(x, y): k for k, (x, y) in enumerate((x, y) for x in range(SIZE + 1) for y in range(SIZE + 1))}
    triangles, quads = [], []
    for x in range(SIZE):
        for y in range(SIZE):
            a, b, c, d = node[x, y], node[x + 1, y], node[x + 1, y + 1], node[x, y + 1]
            if y >= 7:
                quads.append((a, b, c, d))
            elif (x, y) not in HOLE:
                triangles += [(a, b, c), (a, c, d)]
    lines, tags, groups = [], [], {"granite": (1, 2), "basalt": (2, 2)}
    for tag, (name, places) in enumerate(CURVES.items(), 1):
        groups[name] = (tag, 1)
        lines += [(node[p], node[q]) for p, q in pairwise(places)]
        tags += [tag] * (len(places) - 1)
    numbers = [np.full(len(triangles), 1), np.full(len(quads), 2), np.array(tags)]
    return meshio.Mesh(
        np.array([(*place, 0.0) for place in node], dtype=float),
        [("triangle", triangles), ("quad", quads), ("line", lines)],
        cell_data={"gmsh:physical": numbers, "gmsh:geometrical": numbers},
        field_data={name: np.array(group) for name, group in groups.items()},
    )


def scene(shapes: dict[str, Any], paths: dict[str, Any]) -> dict[str, Any]:
    """The block pressed from above, with three cracks."""
    return changed(
        blocks(**shapes),
        units={"length": "mm"},
        cracks={name: {"path": path, "contact": {"friction": 0.2, "cohesion": 0}} for name, path in paths.items()},
        interfaces=joint("granite basalt", contact="bonded"),
        supports=held("granite"),
        loads=[{"on": {"body": "basalt", "edge": "top"}, "traction": ["2 MPa", "-10 MPa"]}],
        numerics={"spacing": 0.7},
    )


def of_mesh() -> dict[str, Any]:
    cracks = ("flat", "kinked", "steep")
    shapes = {name: {"file": "block.msh", "region": name} for name in ("granite", "basalt")}
    return scene(shapes, {name: {"file": "block.msh", "curve": name} for name in cracks})


def written_out() -> dict[str, Any]:
    granite = {**rectangle(0, 0, 12, 7), "holes": [rectangle(8, 3, 2, 2)]}
    points = {"flat": [[2, 5], [5, 5]], "kinked": [[2, 1], [4, 3], [5, 3]], "steep": [[7, 9], [7, 11]]}
    paths = {name: {"points": line} for name, line in points.items()}
    return scene({"granite": granite, "basalt": rectangle(0, 7, 12, 5)}, paths)


def write(mesh: meshio.Mesh, path: Path) -> Path:
    """Write a mesh, in Gmsh's format 2.2."""
    if path.suffix == ".msh":
        meshio.gmsh.write(path, mesh, fmt_version="2.2")
    else:
        meshio.write(path, mesh)
    return path


@pytest.mark.physics
def test_a_specimen_of_gmsh_gives_the_same_K_as_the_scene_written_out(tmp_path: Path):
    write(block(), tmp_path / "block.msh")
    found, wanted = (solve(load(tmp_path, content)).tips[["K_I", "K_II"]] for content in (of_mesh(), written_out()))
    assert len(found) == 6
    assert wanted.abs().max().max() > 1e4
    assert (found - wanted).abs().max().max() <= 1e-10 * wanted.abs().max().max()


def test_regions_of_other_formats_are_values_of_cell_data(tmp_path: Path):
    mesh = block()
    mesh.cell_data = {"rock": mesh.cell_data["gmsh:physical"]}
    read = read_mesh(write(mesh, tmp_path / "block.vtu"))
    rings, edges = read.outline("rock=2")
    assert [ring.tolist() for ring in rings] == [[[0, 7], [12, 7], [12, 12], [0, 12]]]
    assert edges == {}
    whole, _ = read.outline(None)
    assert whole[0].tolist() == [[0, 0], [12, 0], [12, 12], [0, 12]]
    assert len(whole) == 2


def test_faces_with_double_points_are_inside_of_the_rock(tmp_path: Path):
    """As in frames of this program, and where Gmsh has cut a crack: here every triangle has its own points."""
    mesh = block()
    points = mesh.points[mesh.cells[0].data.ravel()]
    apart = meshio.Mesh(points, [("triangle", np.arange(len(points)).reshape(-1, 3))])
    rings, _ = read_mesh(write(apart, tmp_path / "apart.vtu")).outline(None)
    assert [len(ring) for ring in rings] == [4, 4]


def test_a_curve_that_branches_or_closes_is_no_crack(tmp_path: Path):
    mesh = block()
    mesh.cell_data["gmsh:physical"][2][:] = 1
    with pytest.raises(ContentError, match="has a curve 'bottom' that branches, closes or is in several parts"):
        read_mesh(write(mesh, tmp_path / "a.msh")).path("bottom")


@pytest.mark.parametrize(("change", "key", "words"), [
    ({"shape": {"file": "block.msh", "region": "granit"}}, "bodies.granite.shape.region",
     "the mesh has no region 'granit'; it has granite, gmsh:physical=1"),
    ({"shape": {"file": "broken.msh"}}, "bodies.granite.shape.file", "'broken.msh' cannot be read as msh"),
    ({"shape": {"file": "broken.vtu"}}, "bodies.granite.shape.file", "'broken.vtu' cannot be read as vtu"),
    ({"shape": {"file": "rock.wkt", "region": "a"}}, "bodies.granite.shape.region", "has one polygon and no regions"),
    ({"path": {"file": "block.msh", "curve": "flet"}}, "cracks.flat.path.curve", "did you mean 'flat'?"),
    ({"path": {"file": "block.msh"}}, "cracks.flat.path.curve", "missing"),
    ({"path": {"file": "rock.wkt", "curve": "a"}}, "cracks.flat.path.file",
     "'rock.wkt' holds Polygon in shape 1; wanted: lines"),
])  # fmt: skip
def test_what_the_files_do_not_hold_is_told(tmp_path: Path, change: dict[str, Any], key: str, words: str):
    write(block(), tmp_path / "block.msh")
    (tmp_path / "broken.msh").write_text("$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n3\n1 0")
    (tmp_path / "broken.vtu").write_text("<VTKFile")
    (tmp_path / "rock.wkt").write_text("POLYGON ((0 0, 12 0, 12 7, 0 7, 0 0))")
    content = of_mesh()
    (content["cracks"]["flat"] if "path" in change else content["bodies"]["granite"]).update(change)
    with pytest.raises(CaseError) as refused:
        load(tmp_path, content)
    assert refused.value.faults[0].key == key  # cracks that lie in the body may follow
    assert words in refused.value.faults[0].message


SQUARE = [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [2, 1, 0], [2, 2, 0.0]]


@pytest.mark.parametrize(("points", "cells", "words"), [
    ([(x, y, x) for x, y, _ in SQUARE], [("triangle", [[0, 1, 2]])], "is not plane: z goes from 0 to 2"),
    (SQUARE, [("line", [[0, 1]])], "has no cells of surfaces"),
    (SQUARE, [("tetra", [[0, 1, 2, 3]])], r"has cells of volumes \(tetra\)"),
    (SQUARE, [("triangle", [[0, 1, 2], [3, 4, 5]])], "is in several pieces"),
    ([*SQUARE, [3, 0, 0]], [("triangle", [[0, 1, 2], [2, 4, 5]])], r"touches itself at \(1, 1\)"),
])  # fmt: skip
def test_meshes_that_are_no_plane_specimens_are_refused(points: Any, cells: Any, words: str, tmp_path: Path):
    path = write(meshio.Mesh(np.array(points, dtype=float), cells), tmp_path / "a.vtu")
    with pytest.raises(ContentError, match=words):
        read_mesh(path).outline(None)


GMSH = Path(__file__).parent / "gmsh"
"""A triangle as Gmsh 4.15 writes it: `rock`, its curve `bottom`, and `outer` with that and another one."""


@pytest.mark.parametrize("name", ["ov22", "ov41"])
def test_groups_that_overlap_are_read_and_the_smaller_one_names_a_side(name: str):
    (outline,), edges = read_mesh(GMSH / f"{name}.msh").outline("rock")
    assert outline.tolist() == [[0, 0], [1, 0], [0, 1]]
    assert edges == {"bottom": [0], "outer": [1]}
    assert read_mesh(GMSH / f"{name}.msh").path("outer").tolist() == [[0, 0], [1, 0], [0, 1]]


@pytest.mark.parametrize("both", [["rock", "all"], ["all", "rock"]])
def test_a_cell_that_two_groups_have_is_one(both: list[str], tmp_path: Path):
    """Format 2.2 has it twice."""
    groups = {"gmsh:physical": [np.array([1]), np.array([2])], "gmsh:geometrical": [np.array([1]), np.array([1])]}
    names = {name: np.array([tag, 2]) for tag, name in enumerate(both, 1)}
    twice = meshio.Mesh(np.array(SQUARE), 2 * [("triangle", [[0, 1, 2]])], cell_data=groups, field_data=names)
    read = read_mesh(write(twice, tmp_path / "a.msh"))
    assert [len(read.outline(region)[0][0]) for region in (*both, None)] == [3, 3, 3]


@pytest.mark.parametrize(("name", "told"), [
    ("v40", "is of Gmsh's format 4.0, which cannot be read: save it as 4.1 (-format msh41)"),
    ("all41", "has elements with and without a physical group: save it without Mesh.SaveAll (-save_all)"),
    ("all22", "has no cells in its physical groups (bottom, outer, rock): save it without Mesh.SaveAll (-save_all)"),
])  # fmt: skip
def test_how_to_save_is_told_of_what_cannot_be_read(name: str, told: str):
    with pytest.raises(ContentError, match=re.escape(told)):
        read_mesh(GMSH / f"{name}.msh")
