"""Sets of cracks from files: cut where they leave the rock, brought to outlines, and what was changed is told."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from crackgrow import cli
from crackgrow.case import Case, dump_case, load_case
from crackgrow.errors import CaseError

CONTACT = {"friction": 0.3, "cohesion": 0}


def load(folder: Path, lines: list[Any], cracks: dict[str, Any] | None = None, tips: str = "both") -> Case:
    """A block of 1 m on each side with these lines, in mm, as a set of cracks."""
    (folder / "traces.geojson").write_text(json.dumps({"type": "MultiLineString", "coordinates": lines}))
    body = {"shape": {"rectangle": {"center": [500, 500], "width": 1000, "height": 1000}},
            "material": {"young": "10 GPa", "poisson": 0.2}}  # fmt: skip
    joints = {"path": {"file": "traces.geojson"}, "tips": tips, "contact": CONTACT}
    content = {
        "title": "A block with joints", "units": {"length": "mm"}, "plane": "strain", "bodies": {"rock": body},
        "cracks": {"joints": joints, **(cracks or {})}, "numerics": {"spacing": 50},
        "supports": [{"on": {"body": "rock", "edge": "bottom"}, "displacement": {"x": 0, "y": 0}}],
    }  # fmt: skip
    (folder / "scene.yaml").write_text(json.dumps(content))
    return load_case(folder / "scene.yaml")


def tips_of(case: Case) -> list[tuple[str, ...]]:
    ends = [(("start", crack.tip_at_start), ("end", crack.tip_at_end)) for crack in case.cracks]
    return [tuple(end for end, grows in both if grows) for both in ends]


def test_lines_become_cracks_that_end_where_they_leave_the_rock(tmp_path: Path) -> None:
    inside, leaving = [[200, 200], [300, 250], [400, 250]], [[900, 500], [1200, 500]]
    through, outside = [[-100, 700], [1100, 800]], [[1200, 0], [1300, 0]]
    case = load(tmp_path, [inside, leaving, through, outside])
    found = {crack.name: crack for crack in case.cracks}
    assert list(found) == ["joints-1", "joints-2", "joints-3"]
    np.testing.assert_allclose(found["joints-1"].points, np.array(inside) / 1000, rtol=1e-15)
    np.testing.assert_allclose(found["joints-2"].points, [[0.9, 0.5], [1, 0.5]], rtol=1e-15)
    np.testing.assert_allclose(found["joints-3"].points[:, 1], 0.7 + 0.1 / 12 + np.array([0, 0.1 / 1.2]), rtol=1e-12)
    assert tips_of(case) == [("start", "end"), ("start",), ()]
    assert [cut.crack for cut in case.cut] == ["joints-2", "joints-3", "joints-4"]
    assert [cut.whole for cut in case.cut] == [False, False, True]
    np.testing.assert_allclose([cut.length for cut in case.cut], [0.2, np.hypot(1.2, 0.1) / 6, 0.1], rtol=1e-12)


def test_an_end_within_the_tolerance_of_the_outline_lies_on_it(tmp_path: Path) -> None:
    case = load(tmp_path, [[[900, 500], [999.995, 500]], [[900, 600], [1000.005, 600]], [[300, 300], [400, 400]]])
    assert [crack.points[-1][0] for crack in case.cracks] == [1.0, 1.0, 0.4]
    assert tips_of(case) == [("start",), ("start",), ("start", "end")]
    np.testing.assert_allclose([move.distance for move in case.moved], [5e-6], rtol=1e-6)
    np.testing.assert_allclose([cut.length for cut in case.cut], [5e-6], rtol=1e-6)


def test_two_hundred_joints_load_and_the_check_lists_what_was_changed(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    lines = [[[x, y], [x + 60, y + 20]] for x in range(-25, 1015, 100) for y in range(10, 1000, 55)]
    lines = lines[:200]
    case = load(tmp_path, lines)
    assert len(case.cracks) == sum(x < 1000 for (x, _), _ in lines)
    assert len(case.cut) == sum(x < 0 or x + 60 > 1000 for (x, _), _ in lines)
    assert cli.main(["check", str(tmp_path / "scene.yaml")]) == 0
    told = " ".join(capsys.readouterr().out.split())
    assert f"what lies outside of the rock was left out of sets of cracks, lines: {len(case.cut)}: 26.4 mm of" in told


def test_names_of_a_set_are_its_own(tmp_path: Path) -> None:
    other = {"joints-1": {"path": {"points": [[100, 100], [200, 100]]}, "contact": CONTACT}}
    with pytest.raises(CaseError, match=r"cracks\.joints-1: is the name of a crack of the set 'joints'; choose"):
        load(tmp_path, [[[300, 300], [400, 400]]], other)


def test_a_set_makes_no_more_cracks_than_a_case_can_have(tmp_path: Path) -> None:
    zigzag = [[[950 + 100 * (k % 2), k] for k in range(999)]]
    with pytest.raises(CaseError, match=r"cracks: sets make \d+ cracks of it; wanted: 1000 at most"):
        load(tmp_path, [*zigzag, *([[x, 0], [x, 1]] for x in range(1, 900))])


def test_a_set_keeps_the_tips_that_it_is_given(tmp_path: Path) -> None:
    case = load(tmp_path, [[[300, 300], [400, 400]], [[900, 500], [1200, 500]]], tips="end")
    assert tips_of(case) == [("end",), ()]
    (tmp_path / "again.yaml").write_text(dump_case(case))
    (tmp_path / "traces.geojson").unlink()
    again = load_case(tmp_path / "again.yaml")
    assert [crack.points.tolist() for crack in again.cracks] == [crack.points.tolist() for crack in case.cracks]
    assert tips_of(again) == tips_of(case)


def test_a_set_runs_and_its_run_is_gone_on_with(tmp_path: Path) -> None:
    load(tmp_path, [[[300, 300], [500, 400]], [[900, 500], [1200, 500]]])
    run = ["run", str(tmp_path / "scene.yaml"), "--out", str(tmp_path / "out"), "--set", "output.figures=false"]
    assert cli.main([*run, "--set", "output.frames=none"]) == 0
    assert cli.main([*run, "--set", "output.frames=none", "--resume"]) == 0
    warnings = json.loads((tmp_path / "out" / "summary.json").read_text())["warnings"]
    assert any("left out of sets of cracks, lines: 1: 0.2 m of 'joints-2'" in words for words in warnings)


def test_a_table_of_vertices_is_a_set_as_the_paths_of_a_run_are(tmp_path: Path) -> None:
    """Rows in turn of one crack are a line; columns besides do no harm."""
    lines = [[[200, 200], [300, 250], [400, 250]], [[600, 500], [700, 500]]]
    load(tmp_path, lines)
    rows = [f"{name},{k},{x},{y},0" for name, line in zip("ab", lines, strict=True) for k, (x, y) in enumerate(line)]
    (tmp_path / "traces.csv").write_text("\n".join(["crack,vertex,x,y,step", *rows]) + "\n")
    scene = (tmp_path / "scene.yaml").read_text()
    (tmp_path / "table.yaml").write_text(scene.replace("traces.geojson", "traces.csv"))
    one, other = (load_case(tmp_path / f"{name}.yaml") for name in ("scene", "table"))
    for first, second in zip(one.cracks, other.cracks, strict=True):
        assert first.name == second.name
        np.testing.assert_array_equal(first.points, second.points)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("x,y\n1,2\n", "has no column crack; its columns are x, y"),
        ("", "has no column crack or x or y; its columns are none"),
        ("crack,x,y\na,1,1\nb,2,2\nb,3,3\na,4,4\n", "one vertex of 'a', and a line has two or more, in rows one after"),
        ("crack,x,y\na,1,2\n", "one vertex of 'a'"),
        ("crack,x,y\na,1,two\na,3,4\n", "whose x or y is no number"),
        ("crack,x,y\na,1\na,3,4\n", "whose x or y is no number"),
        ("crack,x,y\na,nan,0\na,3,4\n", "finite"),
        ("crack,x,y\n", "nothing"),
    ],
)
def test_fault_of_a_table(text: str, words: str, tmp_path: Path) -> None:
    load(tmp_path, [[[200, 200], [300, 250]]])
    (tmp_path / "traces.csv").write_text(text)
    scene = (tmp_path / "scene.yaml").read_text().replace("traces.geojson", "traces.csv")
    (tmp_path / "scene.yaml").write_text(scene)
    with pytest.raises(CaseError) as caught:
        load_case(tmp_path / "scene.yaml")
    (fault,) = caught.value.faults
    assert fault.key == "cracks.joints.path.file"
    assert words in fault.message
