"""What is made of a run: mesh files and lines of other programs, pictures of frames, and what is refused."""

from __future__ import annotations

import json
import re
import shutil
import sys
from dataclasses import replace
from pathlib import Path
from typing import Any

import ezdxf
import meshio
import numpy as np
import pytest
import pyvista
from PIL import Image

from crackgrow import cli
from crackgrow.cli.command_line import declared
from crackgrow.errors import CaseError
from crackgrow.results import field_picture, render
from crackgrow.results.atomic import FolderError, OutputError
from crackgrow.results.drawn_frame import drawn_frame
from crackgrow.results.export import APPLICATION, FORMATS, PATHS, UNITS, export
from crackgrow.results.folder import open_run
from tests.scenes import make_run

pytestmark = pytest.mark.physics

WITH_FIELDS = [to for to in FORMATS if to not in ("inp", *PATHS)]  # Abaqus' format has none
NAMES = ("stress_xx", "stress_yy", "stress_zz", "stress_xy", "sigma_1", "sigma_3")

LAYERS = """
title: Two layers with a crack
plane: strain
bodies:
  lower: {shape: {rectangle: {center: [0, -1], width: 4, height: 2}}, material: {young: 1 GPa, poisson: 0.2}}
  upper: {shape: {polygon: [[-2, 0], [2, 0], [1.7, 2], [-2, 1.8]]}, material: {young: 2 GPa, poisson: 0.2}}
interfaces: [{between: [lower, upper], contact: {friction: 0.5, cohesion: 0}}]
cracks: {flaw: {path: {points: [[-0.5, -1.2], [0.6, -0.9]]}, contact: {friction: 0.3, cohesion: 0}}}
supports: [{on: {body: lower, edge: bottom}, displacement: {x: 0, y: 0}}]
loads: [{on: {body: upper, edge: "2"}, traction: [0, -1 MPa]}]
loading: {history: [0.5, 1]}
numerics: {spacing: 0.4}
output: {report: false, figures: false, frames: every_step, fields: [displacement, stress, energy_error]}
"""


@pytest.fixture(scope="module")
def layers(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A run of two bodies under two loads, with frames."""
    place = tmp_path_factory.mktemp("layers")
    (place / "layers.yaml").write_text(LAYERS)
    assert cli.main(["run", str(place / "layers.yaml"), "--out", str(place / "run"), "--quiet"]) == 0
    return place / "run"


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A run of four steps with frames."""
    settings = ["output.frames=every_step", "output.fields=[displacement, stress, energy_error]"]
    return make_run(tmp_path_factory.mktemp("run"), settings)


def by_cell(mesh: meshio.Mesh, values: np.ndarray[tuple[int, ...], np.dtype[np.float64]], kind: str) -> object:
    """Values of points at the corners of the cells of a kind: the same however points are numbered."""
    return np.concatenate([values[block.data] for block in mesh.cells if block.type == kind])


@pytest.mark.parametrize("to", WITH_FIELDS)
def test_points_cells_and_fields_are_those_of_the_frame(layers: Path, tmp_path: Path, to: str) -> None:
    path = export(layers, to, step=1, out=tmp_path / f"a.{to}")
    mesh, grid = meshio.read(path), pyvista.read(layers / "frames" / "step_0001.vtu")
    kinds = {block.type for block in mesh.cells}
    assert kinds == {"triangle", "quad"}
    order = np.argsort(grid.cell_data["body"], kind="stable")
    for kind, number in (("triangle", 5), ("quad", 9)):
        chosen = order[grid.celltypes[order] == number]
        corners = np.array([grid.get_cell(cell).point_ids for cell in chosen])
        np.testing.assert_array_equal(by_cell(mesh, mesh.points, kind), grid.points[corners])
        given = {"displacement": grid.point_data["displacement"]}
        given |= dict(zip(NAMES[:4], grid.point_data["stress"].T, strict=False))
        given |= {name: grid.point_data[name] for name in NAMES[4:]}
        for name, values in given.items():
            np.testing.assert_array_equal(by_cell(mesh, mesh.point_data[name], kind), values[corners])
        for name in ("body", "sigma_1", "energy_error"):
            np.testing.assert_array_equal(mesh.cell_data_dict[name][kind], grid.cell_data[name][chosen])


def test_gmsh_has_bodies_as_physical_groups(layers: Path, tmp_path: Path) -> None:
    mesh = meshio.read(export(layers, "msh", out=tmp_path / "a.msh"))
    body = np.concatenate(mesh.cell_data["body"])
    assert {name: group.tolist() for name, group in mesh.field_data.items()} == {"lower": [1, 2], "upper": [2, 2]}
    np.testing.assert_array_equal(np.concatenate(mesh.cell_data["gmsh:physical"]), body + 1)


def test_abaqus_has_sets_of_plane_elements_for_each_body(layers: Path, tmp_path: Path) -> None:
    path = export(layers, "inp", out=tmp_path / "a.inp")
    mesh, grid = meshio.read(path), pyvista.read(layers / "frames" / "step_0001.vtu")
    assert {line for line in path.read_text().splitlines() if line.startswith("*ELEMENT")} == {
        "*ELEMENT, TYPE=CPS3", "*ELEMENT, TYPE=CPS4"}  # fmt: skip
    np.testing.assert_array_equal(mesh.points, grid.points)
    sizes = {name: sum(len(part) for part in parts) for name, parts in mesh.cell_sets.items()}
    kinds = [("triangle", 5), ("quad", 9)]
    assert sizes == {
        f"{name}_{kind}": np.sum((grid.cell_data["body"] == body) & (grid.celltypes == number))
        for body, name in enumerate(("lower", "upper")) for kind, number in kinds
    }  # fmt: skip


def test_the_command_says_where_the_file_is(layers: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert tuple(declared()["words"]["formats"]) == FORMATS
    assert cli.main(["export", str(layers), "--to", "vtk"]) == 0
    assert capsys.readouterr().out == f"{layers / 'export' / 'step_0001.vtk'}\n"
    assert cli.main(["export", str(layers), "--to", "vtk", "--step", "0"]) == 0
    assert sorted(path.name for path in (layers / "export").iterdir()) == ["step_0000.vtk", "step_0001.vtk"]
    assert cli.main(["export", str(layers), "--to", "xdmf", "--out", str(layers / "step.1")]) == 0


@pytest.mark.parametrize(("words", "told"), [
    (["--to", "msh", "--step", "7"], "has no frame of step 7; it has those of 0 to 1"),
    (["--to", "geojson", "--step", "7"], "has no solved step 7; it has 0 to 1"),
    (["--to", "xdmf", "--out", "x.vtk"], "x.vtk: the name ends in .vtk, and the format that is asked for is xdmf"),
])  # fmt: skip
def test_what_cannot_be_exported_is_refused(
    words: list[str], told: str, layers: Path, tmp_path: Path,
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch,
) -> None:  # fmt: skip
    monkeypatch.chdir(tmp_path)
    assert cli.main(["export", str(layers), *words]) == 3
    assert told in capsys.readouterr().err
    assert not list(tmp_path.iterdir())


def features(path: Path) -> list[dict[str, Any]]:
    found = json.loads(path.read_text(encoding="utf-8"))
    assert (found["type"], found["units"], found["crs"]) == ("FeatureCollection", UNITS, None)
    return [feature["properties"] | feature["geometry"] for feature in found["features"]]


def lines_of(path: Path) -> list[dict[str, Any]]:
    return [line for line in features(path) if line["type"] == "LineString"]


def test_lines_are_the_paths_piece_by_piece(folder: Path) -> None:
    lines = lines_of(export(folder, "geojson"))
    assert [(line["kind"], line["tip"], line["step"]) for line in lines] == [
        ("given", "", 0), ("grown", "start", 1), ("grown", "end", 2), ("grown", "end", 3)
    ]  # fmt: skip
    vertices = {tuple(row) for row in open_run(folder).paths[["x", "y"]].to_numpy()}
    assert {tuple(point) for line in lines for point in line["coordinates"]} == vertices
    lengths = [np.linalg.norm(np.diff(line["coordinates"], axis=0), axis=1).sum() for line in lines]
    assert [line["length"] for line in lines] == pytest.approx(lengths)
    assert lengths[1:] == pytest.approx([2e-3] * 3)


@pytest.mark.parametrize(("step", "grown"), [(3, [1, 2, 3]), (1, [1])])
def test_K_of_a_line_is_that_of_the_tip_that_grew_by_it(step: int, grown: list[int], folder: Path) -> None:
    """Also in an earlier step, whose paths and tips are those of then."""
    tips = open_run(folder).tips
    path = export(folder, "geojson", step=step)
    assert path.name == f"step_{step:04d}.geojson"
    found = features(path)
    assert [line["step"] for line in found if line["kind"] == "grown"] == grown
    for line in found:
        if line["kind"] == "given":
            assert line["K_I"] is line["K_II"] is None
            continue
        then = line["step"] - 1 if line["kind"] == "grown" else step
        (row,) = tips[(tips["step"] == then) & (tips["tip"] == line["tip"])].itertuples()
        assert row.advanced or line["kind"] == "tip"
        assert (line["K_I"], line["K_II"]) == (row.K_I, row.K_II)
        if line["kind"] == "tip":
            assert line["coordinates"] == pytest.approx([row.x, row.y], abs=1e-8)


def test_slip_and_opening_are_those_of_the_faces(folder: Path, tmp_path: Path) -> None:
    contact = open_run(folder).contact
    last = contact[contact["step"] == 3]
    given, *_, end = lines_of(export(folder, "geojson"))
    middle = last.iloc[(last["s"] - 9e-3).abs().argmin()]  # of the flaw of 10 mm, behind 4 mm of wing
    assert given["slip"] == pytest.approx(middle["slip"], rel=0.05)
    assert given["opening"] == pytest.approx(0.0, abs=0.05 * abs(given["slip"]))
    assert end["opening"] > 0.1 * abs(given["slip"])
    without = Path(shutil.copytree(folder, tmp_path / "without", ignore=shutil.ignore_patterns("cracks")))
    by_points, *_ = lines_of(export(without, "geojson"))  # a run without frames has its contact points alone
    assert by_points["slip"] == pytest.approx(given["slip"], rel=0.05)


def test_dxf_has_layers_metres_and_attributes(folder: Path) -> None:
    drawing = ezdxf.readfile(export(folder, "dxf"))
    assert drawing.header["$INSUNITS"] == 6  # metres
    assert drawing.audit().errors == []
    known = {}
    for entity in drawing.modelspace():
        told = dict(text.value.split(": ", 1) for text in entity.get_xdata(APPLICATION))
        assert (told["kind"], told["units"]) == (entity.dxf.layer, UNITS)
        at = entity.get_points("xy") if entity.dxftype() == "LWPOLYLINE" else [entity.dxf.location.vec2]
        known[told["kind"], told["tip"], told["step"]] = (told, at)
    for line in features(export(folder, "geojson")):
        told, at = known.pop((line["kind"], line["tip"], str(line["step"])))
        np.testing.assert_allclose(np.reshape(line["coordinates"], (-1, 2)), np.array(at), rtol=1e-12)
        for name in ("K_II", "slip"):
            assert told.get(name) == (None if line[name] is None else str(line[name]))
    assert known == {}


def pixels(path: Path) -> np.ndarray[tuple[int, ...], np.dtype[np.int64]]:
    with Image.open(path) as image:
        return np.asarray(image.convert("RGB"), dtype=np.int64)


def test_every_frame_is_drawn_in_the_size_asked_for_and_in_one_scale(folder: Path, tmp_path: Path) -> None:
    drawn = list(render.render(folder, size=(600, 840), out=tmp_path))
    assert drawn == [tmp_path / "sigma_1" / f"step_{step:04d}.png" for step in range(4)]
    first, *others, last = (pixels(path) for path in drawn)
    for picture in (first, *others, last):
        assert picture.shape == (840, 600, 3)
        assert len(np.unique(picture @ [65536, 256, 1])) > 30
    bar = slice(470, 600)  # right of the specimen: its colour bar, and what that says
    np.testing.assert_array_equal(first[60:, bar], last[60:, bar])
    assert (first[60:, :470] != last[60:, :470]).any()


def test_earlier_pictures_of_the_field_go_and_others_stay(folder: Path, tmp_path: Path) -> None:
    list(render.render(folder, steps=[0, 3], size=(200, 280), out=tmp_path))
    list(render.render(folder, "sigma_3", steps=[0], size=(200, 280), out=tmp_path))
    (tmp_path / "sigma_1" / "own.png").write_text("mine")
    list(render.render(folder, steps=[1], size=(200, 280), out=tmp_path))
    left = sorted(str(path.relative_to(tmp_path)) for path in tmp_path.rglob("*.png"))
    assert left == ["sigma_1/own.png", "sigma_1/step_0001.png", "sigma_3/step_0000.png"]


@pytest.mark.parametrize(("field", "steps", "told"), [
    ("sigma_1", [0, 7, 9], r"has no frame of step 7, 9; it has those of 0 to 3$"),
    # as numbers they would take memory, and the screen
    ("sigma_1", [range(2, 10_000), range(5000, 10**9), 2 * 10**9],
     r"has no frame of step 4 to 999999999, 2000000000; it has those of 0 to 3$"),
    ("sigma_2", None, r"no field 'sigma_2'; it has displacement, stress_xx, .*sigma_3"),
])  # fmt: skip
def test_what_is_not_there_is_refused(
    field: str, steps: list[int | range] | None, told: str, folder: Path, tmp_path: Path
) -> None:
    with pytest.raises(FolderError, match=told):
        list(render.render(folder, field, steps=steps, out=tmp_path))


def test_a_run_without_frames_has_a_report_but_no_pictures(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    run = make_run(tmp_path / "run", ["growth.steps=0", "output.report=false"])
    assert not (run / "report.html").exists()
    assert cli.main(["report", str(run)]) == 0
    assert capsys.readouterr().out == f"{run / 'report.html'}\n"
    assert (run / "report.html").is_file()
    with pytest.raises(FolderError, match=r"no frames to draw: run the case with output\.frames=every_step"):
        list(render.render(run))


def test_mp4_is_made_by_ffmpeg_and_refused_without(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    Image.new("RGB", (31, 21)).save(tmp_path / "0.png")
    monkeypatch.setenv("PATH", str(tmp_path))
    assert cli.main(["render", str(tmp_path), "--mp4"]) == 3  # before anything is read
    assert "an MP4 needs ffmpeg, which is not found" in capsys.readouterr().err
    program = tmp_path / "ffmpeg"  # a stand-in: writes what it is given to its last argument, or fails
    program.write_text(
        f"#!{sys.executable}\nimport sys\nframes = sys.stdin.buffer.read()\n"
        "open(sys.argv[-1], 'wb').write(frames)\nsys.exit('bad frame' if len(frames) > 1000 else 0)\n"
    )
    program.chmod(0o755)
    render.write_mp4(tmp_path / "a.mp4", [tmp_path / "0.png"] * 2)
    assert (tmp_path / "a.mp4").read_bytes() == 2 * (tmp_path / "0.png").read_bytes()
    with pytest.raises(OutputError, match=r"cannot write .*b\.mp4: ffmpeg: bad frame"):
        render.write_mp4(tmp_path / "b.mp4", [tmp_path / "0.png"] * 50)
    assert not (tmp_path / "b.mp4").exists()


def test_view_without_a_display_says_what_to_do(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(render.sys, "platform", "linux")
    for name in ("DISPLAY", "WAYLAND_DISPLAY"):
        monkeypatch.delenv(name, raising=False)
    words = f"no display to open a window on: `crackgrow render {folder}`"
    with pytest.raises(render.NoDisplayError, match=words) as told:
        render.view(folder)
    assert told.value.exit_code == 3


@pytest.mark.parametrize(("limits", "told"), [
    (("5", "-20"), "is not less than '-20'; wanted: the lower limit first"),
    (("0", "5 mm"), "'5 mm' has a unit of length; wanted: a number, in MPa, or with a unit such as 'MPa'"),
    (("nan", "5"), "'nan' is not finite"),
])  # fmt: skip
def test_limits_that_a_field_cannot_have_are_refused(limits: tuple[str, str], told: str) -> None:
    with pytest.raises(CaseError, match=re.escape(told)):
        field_picture.limits_of("sigma_1", limits, (1e6, "MPa"))


@pytest.mark.parametrize(("limits", "wanted", "signed"), [
    (("-2", "1000 kPa"), (-2e6, 1e6), False),  # in the unit of the bar, MPa, or with one
    (("-2 MPa", "2 MPa"), (-2e6, 2e6), True),
    (("0 MPa", "5 MPa"), (0.0, 5e6), False),
])  # fmt: skip
def test_colours_end_at_the_limits_and_white_between_two_of_them_is_zero(
    folder: Path, limits: tuple[str, str], wanted: tuple[float, float], signed: bool
) -> None:
    frame = drawn_frame(open_run(folder), 2, "sigma_1")
    both = replace(frame, values=np.linspace(-1e7, 1e7, len(frame.values)))
    pictures = field_picture.FieldPictures("", "sigma_1", [both], {}, limits=limits)
    shown = (pictures.norm.vmin * pictures.unit[0], pictures.norm.vmax * pictures.unit[0])
    assert shown == pytest.approx(wanted)
    assert (pictures.colormap == "RdBu_r") is signed
