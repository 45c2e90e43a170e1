"""The toughness of the rock, and the averaging radius that follows from it."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pytest

from crackgrow.accuracy.features import size_field
from crackgrow.case import Case, load_case
from crackgrow.case.dump import dump_case
from crackgrow.case.surface import crack_name
from crackgrow.case.toughness import averaging_radius, length_of_average, shear_radius
from crackgrow.cover.shapes import CrackGeometry
from crackgrow.errors import CaseError, Fault
from crackgrow.run.scene import make_scene

FILE = Path(__file__).parent / "compression30.yaml"
TEXT = FILE.read_text(encoding="utf-8")
RADIUS = "  tip_stress:\n    radius: 1 "


def edited(folder: Path, *edits: tuple[str, str]) -> Path:
    """The file of compression30 with texts replaced."""
    text = TEXT
    for old, new in edits:
        assert text.count(old) == 1
        text = text.replace(old, new)
    path = folder / "scene.yaml"
    path.write_text(text, encoding="utf-8")
    return path


def tough(folder: Path, toughness: str = "0.04 MPa sqrt(m)", *edits: tuple[str, str]) -> Path:
    """compression30 with a toughness in place of its radius."""
    return edited(folder, ("tension: 0.5", f"toughness: {toughness}\n      tension: 0.5"), (RADIUS, "#"), *edits)


def faults_of(path: Path, settings: Sequence[str] = ()) -> tuple[Fault, ...]:
    with pytest.raises(CaseError) as caught:
        load_case(path, settings)
    return caught.value.faults


def radius_of(case: Case) -> float:
    strength = case.bodies[0].strength
    assert case.growth is not None
    assert strength is not None
    return averaging_radius(case.growth, strength)


def test_radius_follows_from_tension_and_toughness(tmp_path: Path) -> None:
    case = load_case(tough(tmp_path))
    assert case.growth is not None
    assert case.growth.tip_radius is None
    assert radius_of(case) == pytest.approx((2.0 * 0.04 / 0.5) ** 2 / (2.0 * np.pi), rel=1e-14)


@pytest.mark.parametrize(
    ("text", "value"),
    [("40 kPa sqrt(m)", 4e4), ("40000 Pa sqrt(m)", 4e4), ("4e-5 GPa sqrt(m)", 4e4), ("1 MPa sqrt(mm)", 1e6 / 1e3**0.5)],
)
def test_units_of_a_toughness(text: str, value: float, tmp_path: Path) -> None:
    strength = load_case(tough(tmp_path, text)).bodies[0].strength
    assert strength is not None
    assert strength.toughness == pytest.approx(value, rel=1e-15)


@pytest.mark.parametrize(
    ("criterion", "direction"), [("max_hoop_stress", "implicit"), ("directional_strength", "explicit")]
)
def test_direction_that_is_left_out_is_corrected_where_K_decides_all(
    criterion: str, direction: str, tmp_path: Path
) -> None:
    case = load_case(tough(tmp_path), [f"growth.criterion={criterion}"])
    assert case.growth is not None
    assert case.growth.direction == direction
    plain = load_case(edited(tmp_path), [f"growth.criterion={criterion}"])
    assert plain.growth is not None
    assert plain.growth.direction == "explicit"  # as ever without a toughness


def test_direction_that_is_given_wins(tmp_path: Path) -> None:
    case = load_case(tough(tmp_path), ["growth.criterion=max_hoop_stress", "growth.direction=explicit"])
    assert case.growth is not None
    assert case.growth.direction == "explicit"


def sheared(folder: Path, shear_toughness: str = "0.06 MPa sqrt(m)", *edits: tuple[str, str]) -> Path:
    """compression30 with a toughness in shear beside that in tension."""
    return tough(folder, f"0.04 MPa sqrt(m)\n      shear_toughness: {shear_toughness}", *edits)


def test_radius_for_shear_follows_from_cohesion_and_its_toughness(tmp_path: Path) -> None:
    case = load_case(sheared(tmp_path))
    growth, strength = case.growth, case.bodies[0].strength
    assert growth is not None
    assert strength is not None
    radius = (2.0 * 0.06e6 / strength.cohesion) ** 2 / (2.0 * np.pi)
    assert shear_radius(growth, strength) == pytest.approx(radius, rel=1e-14)
    path = tmp_path / "again.yaml"
    path.write_text(dump_case(case), encoding="utf-8")
    assert dump_case(load_case(path)) == dump_case(case)
    plain = load_case(tough(tmp_path)).bodies[0].strength
    assert plain is not None
    assert shear_radius(growth, plain) is None


def test_toughness_in_shear_is_refused_where_nothing_starts_and_K_decides_all(tmp_path: Path) -> None:
    """Tips would grow in tension alone, as if it was not there."""
    path, by_K = sheared(tmp_path), "growth.criterion=max_hoop_stress"
    for settings in ([by_K], [by_K, "growth.initiation=tips"]):
        (fault,) = faults_of(path, settings)
        assert fault.key == "bodies.rock.strength.shear_toughness"
        assert "unless cracks start in shear" in fault.message
        assert "give growth.initiation: ends" in fault.message
    case = load_case(path, [by_K, "growth.initiation=ends"])
    assert case.growth is not None
    assert case.bodies[0].strength is not None
    assert shear_radius(case.growth, case.bodies[0].strength) is not None


def test_automatic_cells_resolve_the_radius_for_shear(tmp_path: Path) -> None:
    overrides = ["numerics.spacing=auto", "numerics.refine.tips=0", "numerics.refine.kinks=0"]
    case = load_case(sheared(tmp_path, "0.2 MPa sqrt(m)"), overrides)
    strength = case.bodies[0].strength
    assert case.growth is not None
    assert strength is not None
    assert case.numerics.spacing == pytest.approx(2.0 * (shear_radius(case.growth, strength) or 0.0))
    assert "shear toughness of body 'rock'" in str(case.numerics.auto_rule)


def test_automatic_spacing_resolves_the_radius_that_is_averaged_over(tmp_path: Path) -> None:
    overrides = ["numerics.spacing=auto", "numerics.refine.tips=0", "bodies.rock.strength.toughness=0.01 MPa sqrt(m)"]
    case = load_case(tough(tmp_path), [*overrides, "growth.criterion=strength"])
    assert case.numerics.spacing == pytest.approx(2.0 * radius_of(case))  # half a spacing wide at least
    assert "toughness of body 'rock'" in str(case.numerics.auto_rule)
    case = load_case(tough(tmp_path), [*overrides, "growth.criterion=max_hoop_stress"])
    assert "toughness" not in str(case.numerics.auto_rule)  # nothing is averaged


@pytest.mark.parametrize(("criterion", "halved"), [("strength", True), ("max_hoop_stress", False)])
def test_cells_at_tips_resolve_the_radius_that_is_averaged_over(criterion: str, halved: bool, tmp_path: Path) -> None:
    """With automatic cells, whose spacing follows the body; a radius beyond what the crack asks for changes nothing."""
    small = ["numerics.spacing=auto", "growth.steps=1", f"growth.criterion={criterion}"]
    case = load_case(tough(tmp_path, "0.005 MPa sqrt(m)"), small)
    scene = make_scene(case)
    focus = size_field(
        scene, [CrackGeometry(crack_name("flaw"), scene.lattice.to_lattice(case.cracks[0].points), True, True)]
    )
    finest = (
        float(focus.size.min(initial=1.0)) * case.numerics.spacing
    )  # the step's, half of its companion's on twice that
    assert (finest <= 2.0 * radius_of(case) * (1.0 + 1e-9)) == halved


@pytest.mark.parametrize("length", ["growth.tip_stress.radius=1", "bodies.rock.strength.toughness=0.04 MPa sqrt(m)"])
def test_cells_at_tips_resolve_the_radius_for_shear(length: str, tmp_path: Path) -> None:
    """Whether the one for tension is given or follows from a toughness."""
    path = edited(tmp_path, ("tension: 0.5", "shear_toughness: 0.1 MPa sqrt(m)\n      tension: 0.5"), (RADIUS, "#"))
    case = load_case(path, ["numerics.spacing=auto", "growth.steps=1", length])
    growth, strength = case.growth, case.bodies[0].strength
    assert growth is not None
    assert strength is not None
    radius = shear_radius(growth, strength)
    assert radius is not None
    assert length_of_average(growth, strength) == radius < averaging_radius(growth, strength)


def test_bare_number_is_taken_in_metres(tmp_path: Path) -> None:
    edits = (
        ("units: {length: mm, stress: MPa}", "units: {length: m, stress: MPa}"),
        ("spacing: 1.5", "spacing: 1500 mm"),
    )
    strength = load_case(tough(tmp_path, "0.04", *edits)).bodies[0].strength
    assert strength is not None
    assert strength.toughness == 4e4


def test_average_wider_than_the_scene_is_refused_where_there_is_one(tmp_path: Path) -> None:
    path = tough(tmp_path, "10 MPa sqrt(m)")
    (fault,) = faults_of(path)
    assert fault.key == "bodies.rock.strength.toughness"
    assert "more than the size of the scene" in fault.message
    assert load_case(path, ["growth.criterion=max_hoop_stress"]).growth is not None
