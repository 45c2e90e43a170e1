"""Frames read back by pyvista: double nodes, tensor components, time series."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import pyvista

from crackgrow.results import vtk_frames
from tests.unit.results.synthetic import make_frame, make_result


@pytest.mark.parametrize("where", ["points", "cells"])
def test_stress_is_a_named_tensor_with_its_principal_values(tmp_path: Path, where: str) -> None:
    frame = make_frame()
    vtk_frames.write_frame(tmp_path / "a.vtu", frame, ("stress",))
    grid = pyvista.read(tmp_path / "a.vtu")
    data = grid.point_data if where == "points" else grid.cell_data
    given, zz = (frame.point_stress, frame.point_stress_zz) if where == "points" else (frame.stress, frame.stress_zz)
    array = data.VTKObject.GetArray("stress")
    assert [array.GetComponentName(k) for k in range(6)] == ["XX", "YY", "ZZ", "XY", "YZ", "XZ"]
    stress = data["stress"]
    np.testing.assert_array_equal(stress[:, [0, 1, 3]], given)
    np.testing.assert_array_equal(stress[:, 2], zz)
    tensors = np.array([[[xx, xy], [xy, yy]] for xx, yy, xy in given])
    principal = np.linalg.eigvalsh(tensors)  # ascending
    np.testing.assert_allclose(data["sigma_3"], principal[:, 0], rtol=1e-12)
    np.testing.assert_allclose(data["sigma_1"], principal[:, 1], rtol=1e-9)  # cancellation near zero
    assert "displacement" not in grid.point_data


def test_cracks_round_trip(tmp_path: Path) -> None:
    result = make_result(2)
    vtk_frames.write_cracks(tmp_path / "a.vtp", result.faces)
    mesh = pyvista.read(tmp_path / "a.vtp")
    face = result.faces[0]
    assert mesh.n_cells == 1
    np.testing.assert_array_equal(mesh.get_cell(0).point_ids, range(4))
    np.testing.assert_array_equal(mesh.points[:, :2], face.points)
    for name in ("s", "opening", "slip", "normal_traction", "tangential_traction", "state"):
        np.testing.assert_array_equal(mesh.point_data[name], getattr(face, name))
    np.testing.assert_array_equal(mesh.cell_data["crack"], [0])
    assert list(mesh.field_data["crack_names"]) == ["flaw"]


def test_names_in_any_script_round_trip(tmp_path: Path) -> None:
    result = make_result(2)
    vtk_frames.write_cracks(tmp_path / "a.vtp", [replace(face, crack="Spalt_ü節") for face in result.faces])
    names = pyvista.read(tmp_path / "a.vtp").GetFieldData().GetAbstractArray("crack_names")
    assert names.GetValue(0) == "Spalt_ü節"
