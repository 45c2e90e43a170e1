"""Specimens and cracks from mesh files: the same scene as one that is written out, and what is refused."""

from __future__ import annotations

import re
from itertools import pairwise
from pathlib import Path
from typing import Any

import meshio
import numpy as np
import pytest

from crackgrow import solve
from crackgrow.case.mesh_file import ContentError, read_mesh
from crackgrow.errors import CaseError
from tests.unit.case.scenes import blocks, changed, held, joint, load, rectangle

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
