"""A case that was changed in Python: what is written agrees with its fields, or is refused."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest

from crackgrow.case import dump_case, load_case
from crackgrow.case.load import read_case
from crackgrow.case.model import CriticalLoad, LoadHistory
from crackgrow.errors import CaseError
from tests.unit.case.scenes import EVERYTHING, load

FILE = Path(__file__).parent / "compression30.yaml"


def test_changed_settings_are_written():
    case = load_case(FILE)
    assert case.growth is not None
    changed = replace(
        case,
        title="another one",
        numerics=replace(case.numerics, spacing=0.003, contact=replace(case.numerics.contact, stiffness=10.0)),
        growth=replace(case.growth, steps=3, tip_radius=0.002),
        loading=LoadHistory((0.5, 1.0)),
        output=replace(case.output, frames="none"),
    )
    again = read_case(dump_case(changed), "text", case.name)
    assert (again.title, again.numerics.spacing, again.numerics.contact.stiffness) == ("another one", 0.003, 10.0)
    assert again.growth is not None
    assert (again.growth.steps, again.growth.tip_radius, again.output.frames) == (3, 0.002, "none")
    assert again.loading.factors == (0.5, 1.0)  # type: ignore[union-attr]
    assert read_case(dump_case(replace(case, loading=CriticalLoad())), "", "").resolved["loading"] == "critical"


def test_spacing_changed_by_hand_has_no_rule_any_more():
    case = load_case(FILE, ["numerics.spacing=auto"])
    again = read_case(dump_case(replace(case, numerics=replace(case.numerics, spacing=0.001))), "", "")
    assert (again.numerics.spacing, again.numerics.auto_rule) == (0.001, None)


def test_changed_rock_laws_and_loads_are_written(tmp_path: Path):
    case = load(tmp_path, EVERYTHING)
    weight, law = case.loads[2], case.supports[0].contact  # type: ignore[union-attr]
    changed = replace(
        case,
        bodies=tuple(replace(body, material=replace(body.material, young=1e9)) for body in case.bodies),
        cracks=(replace(case.cracks[0], contact=None),),
        interfaces=(replace(case.interfaces[0], contact=replace(law, stiffness=(1e9, 2e9))), case.interfaces[1]),
        supports=(replace(case.supports[0], contact=replace(law, weakening_length=1e-4)), *case.supports[1:]),  # type: ignore[call-arg]
        loads=(*case.loads[:2], replace(weight, acceleration=(1.0, -5.0), held=True), *case.loads[3:]),  # type: ignore[call-arg]
    )
    again = read_case(dump_case(changed), "text", case.name)
    assert [body.material.young for body in again.bodies] == [1e9] * 3
    assert again.cracks[0].contact is None
    assert again.interfaces[0].contact.stiffness == (1e9, 2e9)  # type: ignore[union-attr]
    assert again.supports[0].contact.weakening_length == 1e-4  # type: ignore[union-attr]
    assert (again.loads[2].acceleration, again.loads[2].held) == ((1.0, -5.0), True)  # type: ignore[union-attr]
    assert dump_case(again) == dump_case(changed)


@pytest.mark.parametrize("part", ["bodies", "cracks", "supports", "loads"])
def test_changed_geometry_is_refused(part: str):
    case = load_case(FILE)
    ring = case.bodies[0].rings[0]
    changed = {
        "bodies": (replace(case.bodies[0], rings=(replace(ring, points=2.0 * ring.points),)),),
        "cracks": (replace(case.cracks[0], points=0.5 * case.cracks[0].points),),
        "supports": case.supports[::-1],
        "loads": case.loads[::-1],
    }
    with pytest.raises(CaseError) as caught:
        dump_case(replace(case, **{part: changed[part]}))  # type: ignore[arg-type]
    assert [fault.key for fault in caught.value.faults] == [part]
    assert "cannot be written" in str(caught.value)
