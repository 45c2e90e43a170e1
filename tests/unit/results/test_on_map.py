"""A case in the coordinates of a map: computed as at its origin, and everything told on the map."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import crackgrow
from crackgrow import cli
from crackgrow.api import SolvedRun
from crackgrow.case import Case, dump_case, load_case
from crackgrow.case.on_map import case_on_map

pytestmark = pytest.mark.physics

ORIGIN = (466000.5, 6700000.0)  # m, as of UTM
ULP = 2e-9  # m, two of the largest coordinate's
LOADS = 1e6  # N/m, about
ROUND_OFF = ("residual", "penetration", "complementarity", "overlap", "overlap_share", "energy_error")
FORMULA = 1e-9  # what x of a formula loses of its digits


def scene(x: float, y: float) -> dict[str, Any]:
    """Two blocks with a hole, a joint of a file and a crack that grows into the outline, at a place."""

    def at(*point: float) -> list[float]:
        return [round(point[0] + x, 9), round(point[1] + y, 9)]

    rock = {"material": {"young": "30 GPa", "poisson": 0.2},
            "strength": {"tension": "1 MPa", "cohesion": "5 MPa", "friction_angle": 30}}  # fmt: skip
    low = [at(0, 0), at(8, 0), at(8, 6.4), at(0, 6)]
    top = [at(0, 6), at(8, 6.4), at(8, 8), at(0, 8)]
    contact = {"friction": 0.4, "cohesion": 0}
    return {
        "title": "a case on a map", "plane": "strain", "units": {"length": "m", "stress": "MPa"},
        "bodies": {
            "low": {"shape": {"polygon": low, "holes": [{"disk": {"center": at(6, 4), "radius": 0.5}}]}, **rock},
            "top": {"shape": {"polygon": top}, **rock},
        },
        "interfaces": [{"between": ["low", "top"], "contact": "bonded"}],
        "cracks": {
            "flaw": {"path": {"center": at(1.3, 2.2), "length": 1.7, "angle": 20}, "contact": contact},
            "joints": {"path": {"file": "joints.geojson"}, "contact": contact},
        },
        "supports": [
            {"at": at(8, 0), "displacement": {"x": 0, "y": 0}, "body": "low"},
            {"on": {"body": "low", "edge": "0", "from": at(1, 0)[0], "to": at(5, 0)[0]}, "displacement": {"y": 0}},
        ],
        "loads": [
            {"on": {"body": "top", "edge": "2"}, "traction": [0, f"3 + 0.1*(x - {x!r})"]},
            {"at": at(0, 3), "force": ["-20 kN/m", "0 N/m"], "body": "low"},
        ],
        "growth": {"steps": 2, "increment": 0.8, "criterion": "strength", "tip_stress": {"radius": 0.4}},
        "numerics": {"spacing": 0.8},
        "output": {"points": {
            "wall": {"at": at(5.5, 4), "body": "low"}, "way": {"between": [at(1, 1), at(7, 1)]},
            "mouth": {"crack": "flaw", "at": at(1.3, 2.2)},
        }},
    }  # fmt: skip


def write(folder: Path, x: float, y: float, **units: Any) -> Path:
    folder.mkdir()
    content = scene(x, y)
    content["units"] |= units
    line = [[round(x + a, 9), round(y + b, 9)] for a, b in ((3.1, 4.2), (4.7, 4.9), (6.3, 4.1))]  # ends in the hole
    shape = {"type": "LineString", "coordinates": line}
    (folder / "joints.geojson").write_text(json.dumps(shape))
    (folder / "rock.yaml").write_text(json.dumps(content))
    return folder / "rock.yaml"


@pytest.fixture(scope="module")
def files(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Path]:
    """The same case at its origin and on the map."""
    folder = tmp_path_factory.mktemp("on_map")
    return write(folder / "here", 0.0, 0.0), write(folder / "map", *ORIGIN, origin=list(ORIGIN))


@pytest.fixture(scope="module")
def cases(files: tuple[Path, Path]) -> tuple[Case, Case]:
    return load_case(files[0]), load_case(files[1])


@pytest.fixture(scope="module")
def runs(files: tuple[Path, Path], cases: tuple[Case, Case]) -> tuple[SolvedRun, SolvedRun]:
    here, there = (crackgrow.run_case(case, file.parent / "out") for case, file in zip(cases, files, strict=True))
    return here, there


def test_a_case_is_seen_from_its_origin(cases: tuple[Case, Case]) -> None:
    here, there = cases
    assert there.origin == ORIGIN
    assert len(there.cut) == 1
    for one, other in zip(here.cracks, there.cracks, strict=True):
        np.testing.assert_array_equal(one.points, other.points)
    for one, other in zip(here.bodies, there.bodies, strict=True):
        for ring, its in zip(one.rings, other.rings, strict=True):
            np.testing.assert_array_equal(ring.points, its.points)
    on_map = case_on_map(there)
    np.testing.assert_allclose(on_map.cracks[0].points - here.cracks[0].points, [ORIGIN] * 2, rtol=1e-15)
    np.testing.assert_allclose(on_map.output.points[1].points[0], np.add(ORIGIN, 1.0), rtol=1e-15)  # type: ignore[union-attr]


def test_a_case_as_it_ran_stands_on_the_map_and_reads_back_to_the_same_bits(
    cases: tuple[Case, Case], tmp_path: Path
) -> None:
    here, there = cases
    text = dump_case(there)
    assert "center: [466001.8, 6700002.2]" in text
    assert "from: 466001.5" in text
    (tmp_path / "rock.yaml").write_text(text)
    again = load_case(tmp_path / "rock.yaml")
    assert dump_case(again) == text
    for one, other in zip(there.cracks, again.cracks, strict=True):
        np.testing.assert_array_equal(one.points, other.points)
    changed = there.with_("cracks.flaw.path.center=[466003.5, 6700002]", "output.points={}")
    np.testing.assert_allclose(changed.cracks[0].points.mean(axis=0), [3.0, 2.0], rtol=1e-14)
    np.testing.assert_array_equal(changed.cracks[1].points, here.cracks[1].points)


def test_results_are_the_same_on_the_map(runs: tuple[SolvedRun, SolvedRun]) -> None:
    here, there = runs
    for name in ("tips", "contact", "paths", "events", "steps", "reactions", "history"):
        one, other = getattr(here, name), getattr(there, name)
        assert len(one) == len(other) > 0, name
        for column in one:
            if column.startswith("seconds") or column in ROUND_OFF:
                continue
            if column in "xy":
                shifted = one[column] + ORIGIN["xy".index(column)]
                np.testing.assert_allclose(other[column], shifted, rtol=0.0, atol=ULP, err_msg=f"{name}.{column}")
            elif one[column].dtype.kind == "f":
                alike = [other for other in one if other.partition(".")[2] == column.partition(".")[2]]
                of_loads = LOADS if "force" in column else 0.0  # that balance: reactions are their round-off
                known = one[alike if "." in column else [column]].to_numpy()
                size = FORMULA * max(np.abs(known[np.isfinite(known)]).max(initial=0.0), of_loads)
                np.testing.assert_allclose(other[column], one[column], FORMULA, size, err_msg=f"{name}.{column}")
            else:
                assert one[column].equals(other[column]), f"{name}.{column}"


def test_fields_and_meshes_are_on_the_map(runs: tuple[SolvedRun, SolvedRun], files: tuple[Path, Path]) -> None:
    here, there = runs
    points = np.array([[1.0, 1.0], [4.0, 7.2], [20.0, 0.0]])
    for name in ("displacement_at", "stress_at"):
        one, other = getattr(here.last, name)(points), getattr(there.solution(2), name)(points + ORIGIN)
        np.testing.assert_allclose(one, other, rtol=FORMULA)
    for mesh in (there.mesh(1), crackgrow.open_run(files[1].parent / "out").mesh(1)):
        np.testing.assert_allclose(mesh.points[:, :2], here.mesh(1).points[:, :2] + ORIGIN, rtol=0.0, atol=ULP)
    for one, other in zip(here.results[1].faces, there.results[1].faces, strict=True):
        np.testing.assert_allclose(other.points, one.points + ORIGIN, rtol=0.0, atol=ULP)


def test_what_is_told_of_places_is_on_the_map(
    runs: tuple[SolvedRun, SolvedRun], files: tuple[Path, Path], capsys: pytest.CaptureFixture[str]
) -> None:
    assert "'joints-1' (the shape) at (466006.5 m, 6700004.25 m)" in " ".join(runs[1].warnings)
    folder = files[1].parent
    event = runs[1].events[runs[1].events["met"] != ""].iloc[0]
    assert f"({event.x:.4f}"[:9] in (folder / "out" / "run.log").read_text()
    assert "466008.5" in (folder / "out" / "report.html").read_text()  # of a support
    assert cli.main(["check", str(files[1]), "--picture", str(folder / "scene.svg")]) == 0
    assert "(466006.5 m, 6700004.25 m)" in capsys.readouterr().out
