"""What is written of cases and read again, short forms, cases made in Python; toughness, accuracy, automatic cells."""

from __future__ import annotations

import copy
import pickle
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml

from crackgrow.case import Case, dump_case, load_case
from crackgrow.case.accuracy import REFINED_AT, TARGETS, cells_along
from crackgrow.case.dump import written
from crackgrow.case.load import read_case
from crackgrow.case.model import LoadHistory
from crackgrow.case.sizing import Length, automatic_spacing
from crackgrow.case.toughness import averaging_radius, shear_radius
from crackgrow.errors import CaseError
from crackgrow.plan.text import overview
from tests.unit.case.scenes import (
    CASES,
    COMPRESSION,
    EVERYTHING,
    NAMES,
    compression,
    edited,
    held,
    load,
    rectangle,
    reread,
    same,
    with_body,
)

# --- what is written and read again ----------------------------------------------------------------------------------


@pytest.mark.physics
@pytest.mark.parametrize("name", NAMES)
def test_every_shipped_case_reads_back_also_from_a_writer_of_yaml_1_1(
    name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
):
    """To PyYAML the key `on` is the boolean true."""
    case = load_case(CASES / f"{name}.yaml")
    again = reread(case, tmp_path)
    told: dict[str, Any] = {"moved": (), "cut": ()}  # of the map, which was brought together when it was read first
    assert same(replace(case, **told), replace(again, **told))
    assert dump_case(again) == dump_case(case)
    monkeypatch.chdir(CASES)  # where the files lie that a case names
    text = yaml.safe_dump(yaml.safe_load((CASES / f"{name}.yaml").read_text(encoding="utf-8")))
    assert written(read_case(text, "written", name)) == written(case)


def test_what_is_changed_in_python_is_written(tmp_path: Path):
    case = load(tmp_path, EVERYTHING, "numerics.spacing=auto")
    law, weight = case.supports[0].contact, case.loads[2]
    changed = replace(
        case,
        title="another one",
        bodies=tuple(replace(body, material=replace(body.material, young=1e9)) for body in case.bodies),
        cracks=(replace(case.cracks[0], contact=None),),
        interfaces=(replace(case.interfaces[0], contact=replace(law, stiffness=(1e9, 2e9))), case.interfaces[1]),
        supports=(replace(case.supports[0], contact=replace(law, weakening_length=1e-4)), *case.supports[1:]),
        loads=(*case.loads[:2], replace(weight, acceleration=(1.0, -5.0), held=True), *case.loads[3:]),
        numerics=replace(case.numerics, spacing=0.001, contact=replace(case.numerics.contact, stiffness=10.0)),
        growth=replace(case.growth, steps=3, tip_radius=0.002),
        loading=LoadHistory((0.5, 1.0)),
        output=replace(case.output, frames="none"),
    )
    again = read_case(dump_case(changed), "text", case.name)
    for part in ("title", "bodies", "cracks", "interfaces", "supports", "loads", "growth", "loading", "output"):
        assert same(getattr(again, part), getattr(changed, part)), part
    assert same(again.numerics, replace(changed.numerics, auto_rule=None))


def test_changed_geometry_is_not_written():
    case = compression()
    ring = case.bodies[0].rings[0]
    larger = replace(case.bodies[0], rings=(replace(ring, points=2.0 * ring.points),))
    shorter = replace(case.cracks[0], points=0.5 * case.cracks[0].points)
    for changed, part in ((replace(case, bodies=(larger,)), "bodies"), (replace(case, cracks=(shorter,)), "cracks")):
        with pytest.raises(CaseError, match=f"{part}: .*cannot be written"):
            dump_case(changed)


def test_a_case_is_not_changed_from_outside():
    case = compression()
    text = dump_case(case)
    case.to_dict()["bodies"]["rock"]["material"]["young"] = 1.0
    sent = pickle.loads(pickle.dumps(case))
    assert (dump_case(sent), dump_case(copy.deepcopy(case))) == (text, text)
    region = case.loads[0].region
    for array in (case.bodies[0].outline, case.cracks[0].points, case.supports[0].point, region.sides, region.limits):
        with pytest.raises(ValueError, match="read-only"):
            array[0] = 1
    assert dump_case(case) == text


# --- cases from mappings ---------------------------------------------------------------------------------------------

PLATE = {**with_body(rectangle(0, 0, 4, 6)), "supports": held("rock"), "numerics": {"spacing": "auto"}}


def test_a_mapping_is_the_case_that_its_file_is(tmp_path: Path):
    """Also one that a reader of YAML 1.1 has made, which takes the key `on` for true."""
    case = Case.from_dict(EVERYTHING, "everything")
    assert dump_case(case) == dump_case(load(tmp_path, EVERYTHING))
    assert same(Case.from_dict(case.to_dict(), case.name), case)
    assert yaml.safe_load(dump_case(case)) == case.to_dict()
    scene = {**PLATE, "loads": [{"on": {"edge": "top"}, "traction": [0, 1]}]}
    read = {**scene, "loads": [{True: {"edge": "top"}, "traction": [0, 1]}]}
    assert dump_case(Case.from_dict(read)) == dump_case(load(tmp_path, scene))


def test_a_mapping_keeps_all_digits_of_coordinates_on_a_map():
    """Where ends were joined they have more of them than a float on the map."""
    case = load_case(CASES / "joint_map.yaml")
    mapping = case.to_dict()
    assert mapping == yaml.safe_load(dump_case(case))
    for copied in (mapping, copy.deepcopy(mapping), pickle.loads(pickle.dumps(mapping))):
        assert dump_case(Case.from_dict(copied, case.name)) == dump_case(case)


def test_settings_are_those_of_the_command_line(tmp_path: Path):
    settings = ["bodies.rock.shape.rectangle.width=200 cm", "plane=stress"]
    case = load(tmp_path, PLATE)
    assert dump_case(case.with_(*settings)) == dump_case(load_case(tmp_path / "scene.yaml", settings))
    assert case.plane == "strain"


def test_faults_of_mappings_name_keys_and_no_lines():
    with pytest.raises(CaseError) as caught:
        Case.from_dict({**PLATE, "plane": "strian", "growht": {}})
    assert [(fault.key, fault.line) for fault in caught.value.faults] == [("plane", None), ("growht", None)]
    with pytest.raises(CaseError, match=r"numerics\.spacng: unknown key"):
        Case.from_dict(PLATE).with_("numerics.spacng=1")
    with pytest.raises(TypeError, match="a mapping in the case format is wanted, not str"):
        Case.from_dict("title: x")
    with pytest.raises(TypeError, match=r"loads\.0: set given"):
        Case.from_dict({**PLATE, "loads": [{1, 2}]})


# --- toughness, and the averaging radius that follows from it --------------------------------------------------------

RADIUS = ("  tip_stress:\n    radius: 1 ", "#")


def tough(folder: Path, toughness: str = "0.04 MPa sqrt(m)", *edits: tuple[str, str]) -> Path:
    """compression30 with a toughness in place of its radius."""
    return edited(folder, ("tension: 0.5", f"toughness: {toughness}\n      tension: 0.5"), RADIUS, *edits)


def sheared(folder: Path, shear_toughness: str = "0.06 MPa sqrt(m)") -> Path:
    """compression30 with a toughness in shear beside that in tension."""
    return tough(folder, f"0.04 MPa sqrt(m)\n      shear_toughness: {shear_toughness}")


def radius_of(case: Case) -> float:
    return averaging_radius(case.growth, case.bodies[0].strength)


def shear_radius_of(case: Case) -> float | None:
    return shear_radius(case.growth, case.bodies[0].strength)


def test_radii_follow_from_strengths_and_toughnesses(tmp_path: Path):
    case = load_case(sheared(tmp_path))
    assert case.growth.tip_radius is None
    assert radius_of(case) == pytest.approx((2.0 * 0.04 / 0.5) ** 2 / (2.0 * np.pi), rel=1e-14)
    cohesion = case.bodies[0].strength.cohesion
    assert shear_radius_of(case) == pytest.approx((2.0 * 0.06e6 / cohesion) ** 2 / (2.0 * np.pi), rel=1e-14)
    assert dump_case(reread(case, tmp_path)) == dump_case(case)
    by_K = ["growth.criterion=max_hoop_stress", "growth.initiation=ends"]  # where K decides all but starts
    assert shear_radius_of(load_case(sheared(tmp_path), by_K)) is not None
    assert shear_radius_of(load_case(tough(tmp_path))) is None


def test_automatic_spacing_resolves_the_radii_that_are_averaged_over(tmp_path: Path):
    automatic = ["numerics.spacing=auto", "numerics.refine.tips=0"]
    case = load_case(sheared(tmp_path, "0.2 MPa sqrt(m)"), [*automatic, "numerics.refine.kinks=0"])
    assert case.numerics.spacing == pytest.approx(2.0 * (shear_radius_of(case) or 0.0))  # half a spacing wide at least
    assert "shear toughness of body 'rock'" in str(case.numerics.auto_rule)
    path = tough(tmp_path, "0.01 MPa sqrt(m)")
    case = load_case(path, [*automatic, "growth.criterion=strength"])
    assert case.numerics.spacing == pytest.approx(2.0 * radius_of(case))
    assert "toughness of body 'rock'" in str(case.numerics.auto_rule)
    case = load_case(path, [*automatic, "growth.criterion=max_hoop_stress"])
    assert "toughness" not in str(case.numerics.auto_rule)  # nothing is averaged


# --- the rule --------------------------------------------------------------------------------------------------------

WIDE = Length("width", 20.0, "wide")
THIN = [WIDE, Length("tip", 0.05, "crack"), Length("width", 10.0, "thin")]
TINY = [*THIN, Length("tip", 0.0002, "tiny")]


@pytest.mark.parametrize(("lengths", "refined", "spacing", "rule"), [
    ([Length("tip", 10.0, "crack a"), Length("tip", 2.0, "crack b"), WIDE], None, 1.0, "crack b / 2"),
    ([Length("tip", 10.0, "crack a"), WIDE, Length("width", 5.0, "thin")], None, 0.5, "thin / 10"),
    ([Length("tip", 10.0, "crack a"), WIDE, Length("increment", 0.5, "step")], None, 0.5, "step / 1"),
    ([WIDE, Length("increment", 1.0, "step"), Length("radius", 0.25, "radius")], None, 0.5, "radius / 0.5"),
    ([WIDE], None, 2.0, "wide / 10"),
    ([WIDE, Length("feature", 4.0, "hole")], None, 0.5, "hole / 8"),
    ([WIDE, Length("bridge", 4.5, "rock"), Length("support", 8.0, "foot")], None, 1.5, "rock / 3"),
    ([WIDE, Length("support", 2.0, "foot")], None, 0.5, "foot / 4"),
    ([WIDE, Length("load", 1.0, "strip")], None, 0.5, "strip / 2"),
    # where cells are refined, a length counts by the smallest of them
    (THIN, "tips", 1.0, "thin / 10"),
    (TINY, "tips", 0.4096, "tiny / 2 x 2^12"),
    (TINY, "corners", 0.0001, "tiny / 2"),
])  # fmt: skip
def test_the_smallest_length_rules(lengths: list[Length], refined: str | None, spacing: float, rule: str):
    at = (REFINED_AT[refined],) if refined else ()
    assert automatic_spacing("standard", lengths, *at) == (spacing, rule)


# --- presets and targets ---------------------------------------------------------------------------------------------


def without_numerics(folder: Path, *lines: str) -> Path:
    """compression30 whose numerics are these lines alone."""
    text = COMPRESSION[: COMPRESSION.index("  spacing: 1.5")] + "".join(f"  {line}\n" for line in lines)
    (folder / "scene.yaml").write_text(text, encoding="utf-8")
    return folder / "scene.yaml"


@pytest.mark.parametrize(("word", "target"), TARGETS.items())
def test_a_preset_is_a_target_and_is_listed_in_the_resolved_case(word: str, target: float, tmp_path: Path):
    case = load_case(without_numerics(tmp_path, f"accuracy: {word}"))
    assert (case.numerics.target, case.numerics.measured) == (target, True)
    listed = case.to_dict()["numerics"]
    assert (listed["accuracy"], listed["support"], listed["quadrature"]) == (word, 2.0, 3)
    assert listed["spacing"] == pytest.approx(0.031 / cells_along("width", word), rel=1e-12)
    assert listed["auto_rule"].startswith("smaller side of body 'rock' / ")
    assert f"(auto, {word}: smaller side of body 'rock' / " in overview(case)
    assert listed["refine"] == {"tips": "auto", "kinks": "auto", "corners": "auto", "rings": 2.0}


def test_explicit_keys_win_and_leave_the_others_to_the_preset(tmp_path: Path):
    listed = load_case(without_numerics(tmp_path, "accuracy: fine", "spacing: 2.5")).to_dict()["numerics"]
    assert (listed["accuracy"], listed["spacing"], "auto_rule" in listed) == ("fine", 0.0025, False)
    whole = load_case(without_numerics(tmp_path, "accuracy: draft")).to_dict()["numerics"]
    part = load_case(without_numerics(tmp_path, "accuracy: draft", "support: 3")).to_dict()["numerics"]
    assert part == {**whole, "support": 3.0}
    assert "spacing 1.5 mm, support" in overview(compression())
    told = overview(compression("numerics.accuracy=fine"))
    assert "spacing 1.5 mm (given, not that of fine), support" in told


def test_resolved_automatic_case_reads_back_and_keeps_its_rule(tmp_path: Path):
    case = compression("numerics.spacing=auto")
    assert reread(case, tmp_path).numerics.auto_rule == case.numerics.auto_rule is not None
    for setting in ("numerics.spacing=0.001", "bodies.rock.shape.rectangle.width=0.032"):  # not the rule's any more
        assert load_case(tmp_path / "compression30.yaml", [setting]).numerics.auto_rule is None
