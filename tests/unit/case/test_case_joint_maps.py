"""Synthetic maps of joints: every one loads with a list of what was changed, and is joined as it means to be."""

from __future__ import annotations

import json
import re
from collections import Counter
from pathlib import Path

import numpy as np
import pytest
import shapely
import yaml

from crackgrow import cli
from crackgrow.case import Case, dump_case, load_case
from tests.joint_maps import SHIPPED, JointMap, case_text, joint_map
from tests.scenes import shipped_case

CASES = Path(__file__).parents[3] / "cases"
MAPS = [(50, seed) for seed in range(12)] + [(200, seed) for seed in range(3)] + [(700, 0)]


def load(map_: JointMap, folder: Path) -> Case:
    (map_.write(folder) / "scene.yaml").write_text(case_text(map_))
    return load_case(folder / "scene.yaml")


@pytest.mark.parametrize(("n", "seed"), MAPS)
def test_a_map_loads_and_is_brought_together(n: int, seed: int, tmp_path: Path) -> None:
    """No tip is left within the tolerance of anything, and none of the joints that are well drawn is lost."""
    map_ = joint_map(n, seed)
    case = load(map_, tmp_path)
    lines = [shapely.LineString(crack.points) for crack in case.cracks]
    rims = [shapely.LinearRing(ring.points) for ring in case.bodies[0].rings]
    tree = shapely.STRtree([*lines, *rims])
    ends = [
        (k, end)
        for k, crack in enumerate(case.cracks)
        for end in (0, -1)
        if (crack.tip_at_start, crack.tip_at_end)[end]
    ]
    tips = shapely.points([case.cracks[k].points[end] for k, end in ends])
    near = tree.query(tips, predicate="dwithin", distance=0.999 * map_.tolerance).T.tolist()
    assert [(tip, other) for tip, other in near if other != ends[tip][0]] == []
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


def test_a_map_as_it_ran_reads_back_to_the_same(tmp_path: Path) -> None:
    case = load(joint_map(200, 3), tmp_path)
    text = dump_case(case)
    (tmp_path / "again.yaml").write_text(text)
    again = load_case(tmp_path / "again.yaml")
    assert dump_case(again) == text
    for one, other in zip(case.cracks, again.cracks, strict=True):
        np.testing.assert_array_equal(one.points, other.points)
        assert (one.tip_at_start, one.tip_at_end) == (other.tip_at_start, other.tip_at_end)


def test_laws_follow_the_sets_of_joints(tmp_path: Path) -> None:
    map_ = joint_map(50, 1)
    sets = {str(number): values["set"] for number, (_, values) in enumerate(map_.traces, 1)}
    for crack in load(map_, tmp_path).cracks:
        assert crack.contact is not None
        assert crack.contact.friction == (0.4 if sets[crack.name.split("-")[1]] == "J2" else 0.7)


@pytest.mark.parametrize(("n", "seed"), [(50, 3), (200, 1), (700, 1)])
def test_a_map_is_checked(n: int, seed: int, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    load(joint_map(n, seed), tmp_path)
    assert cli.main(["check", str(tmp_path / "scene.yaml")]) == 0
    told = capsys.readouterr().out
    assert "these were moved: " in told
    assert "was left out of cracks, " in told


@pytest.mark.slow
def test_fifty_joints_grow(tmp_path: Path) -> None:
    """Pulled apart, so that most faces open: slip along connected joints takes contact long."""
    map_ = joint_map(50, 1)
    load(map_, tmp_path)
    held = [f"{{on: {{edge: {k}}}, displacement: {{x: 0, y: 0}}}}" for k in range(len(map_.outline))]
    rock = "{young: 60 GPa, poisson: 0.25}, strength: {tension: 5 MPa, cohesion: 20 MPa, friction_angle: 40, "
    text = case_text(
        map_,
        bodies=f"{{rock: {{shape: {{file: outline.geojson}}, material: {rock}toughness: 1 MPa sqrt(m)}}}}}}",
        supports=f"[{', '.join(held)}]",
        loads="[{stress: [10, 10, 0]}]",
        loading="critical",
        growth="{steps: 2, increment: 0.3, criterion: max_hoop_stress, direction: explicit, advance: most_critical}",
        output="{frames: none, figures: false, report: false}",
    )
    (tmp_path / "grows.yaml").write_text(text)
    assert cli.main(["run", str(tmp_path / "grows.yaml"), "--out", str(tmp_path / "out"), "--quiet"]) == 0
    rows = np.genfromtxt(tmp_path / "out" / "paths.csv", delimiter=",", names=True, dtype=None, encoding="utf-8")
    assert set(rows["step"].tolist()) == {0, 1, 2}
    grown = rows[rows["step"] > 0]
    ends = np.column_stack([grown["x"], grown["y"]])
    assert all(shapely.Polygon(map_.outline).covers(shapely.Point(end)) for end in ends)
    given = shapely.MultiLineString([points for points, _ in map_.traces])
    assert all(given.distance(shapely.Point(end)) < 2.0 * 0.3 + 0.5 for end in ends)  # two increments, what was moved


def test_the_shipped_map_is_one_of_these(tmp_path: Path) -> None:
    joint_map(*SHIPPED).write(tmp_path, "joint_map_")
    for name in ("joint_map_joints.geojson", "joint_map_outline.geojson"):
        made, shipped = (json.loads((folder / name).read_text())["features"] for folder in (tmp_path, CASES))
        for one, other in zip(made, shipped, strict=True):
            assert one["properties"] == other["properties"]
            np.testing.assert_allclose(one["geometry"]["coordinates"], other["geometry"]["coordinates"], atol=2e-6)


def test_the_page_on_maps_shows_the_shipped_case() -> None:
    (shown,) = re.findall(r"^```yaml\n(.*?)^```$", (CASES / "MAPS.md").read_text(), flags=re.MULTILINE | re.DOTALL)
    whole = yaml.safe_load((CASES / "joint_map.yaml").read_text())
    for key, value in yaml.safe_load(shown).items():
        assert value == whole[key]


def test_the_shipped_map_is_brought_together_and_told(capsys: pytest.CaptureFixture[str]) -> None:
    case = shipped_case("joint_map")
    assert len(json.loads((CASES / "joint_map_joints.geojson").read_text())["features"]) == 46
    assert (len(case.cracks), len({crack.name.split("-")[1] for crack in case.cracks})) == (43, 39)
    frictions = Counter(crack.contact.friction for crack in case.cracks if crack.contact is not None)
    assert set(frictions) == {0.4, 0.7}
    assert cli.main(["check", str(CASES / "joint_map.yaml")]) == 0
    told = capsys.readouterr().out
    assert "these were moved: the end of crack 'joints-3'" in told
    assert "all of 'joints-18' (feature 18)" in told
