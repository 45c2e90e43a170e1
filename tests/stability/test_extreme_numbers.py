"""Numbers that are not finite, too large or too small, in every place of a case: an error that names the place."""

from __future__ import annotations

import contextlib
import copy
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from crackgrow.case import load_case
from crackgrow.errors import CaseError, CrackgrowError, SolveError
from crackgrow.run import grow
from tests.scenes import shipped_case
from tests.stability.growing_scenes import text_of
from tests.unit.case import scenes
from tests.unit.case.scenes import changed

Key = tuple[str | int, ...]

LAW = {"friction": 0.3, "cohesion": 0.1, "residual_friction": 0.2, "dilation_angle": 5}
EVERYTHING: dict[str, Any] = changed(
    scenes.EVERYTHING,
    cracks={"flaw": {"path": {"points": [[-2, 15], [0, 16], [2, 17]]}, "contact": LAW}},
    loading={"history": [0.5, 1.0]},
    growth={**scenes.EVERYTHING["growth"], "criterion": "strength", "direction": "explicit", "steps": 1},
    numerics={"spacing": 1, "support": 2.0, "quadrature": 3, "contact": {"stiffness": 100, "spacing": 1.25}},
    output={"frames": "none", "figures": False},
)
"""Every key that takes a number."""


def numbers(value: Any, key: Key = ()) -> Iterator[Key]:
    """The keys of all numbers in a document."""
    if isinstance(value, dict | list):
        for inner, part in value.items() if isinstance(value, dict) else enumerate(value):
            yield from numbers(part, (*key, inner))
    elif isinstance(value, int | float) and not isinstance(value, bool):
        yield key


KEYS = tuple(numbers(EVERYTHING))
DISPLACEMENT: Key = ("supports", 1, "displacement", "y")


def written(folder: Path, changes: dict[Key, str]) -> Path:
    """The document as a file, with other numbers at some keys."""
    document = copy.deepcopy(EVERYTHING)
    for number, key in enumerate(changes):
        place = document
        for part in key[:-1]:
            place = place[part]
        place[key[-1]] = f"@{number}@"
    text = text_of(document)
    for number, value in enumerate(changes.values()):
        text = text.replace(f"'@{number}@'", value)
    path = folder / "scene.yaml"
    path.write_text(text, encoding="utf-8")
    return path


def name_of(key: Key) -> str:
    return ".".join(str(part) for part in key)


def solved_to_the_end(path: Path) -> None:
    """Every number of a result that must be one is finite."""
    for result in grow(load_case(path)):
        energy = result.energy
        found = [result.residual, result.penetration, result.complementarity, result.overlap, result.load_displacement]
        found += [energy.work, energy.strain, energy.dissipated, energy.released, energy.error, result.crack_length]
        assert np.isfinite(found).all()
        for values in (result.contact.normal_traction, result.contact.tangential_traction, result.contact.opening):
            assert np.isfinite(values).all()


@pytest.mark.parametrize("value", [".nan", "-.inf", "1e400", "-1e300", "1e-300"])
def test_numbers_that_none_can_mean_are_refused_where_they_stand(tmp_path: Path, value: str) -> None:
    with pytest.raises(CaseError) as caught:
        load_case(written(tmp_path, dict.fromkeys(KEYS, value)))
    assert {name_of(key) for key in KEYS} <= {fault.key for fault in caught.value.faults if value in fault.message}


@pytest.mark.slow
@pytest.mark.parametrize("key", KEYS, ids=name_of)
def test_numbers_that_can_be_read_are_solved_or_refused(tmp_path: Path, key: Key) -> None:
    """No warning and no other kind of error, whatever the size: `filterwarnings` makes errors of warnings."""
    solved_to_the_end(written(tmp_path, {}))
    for value in ("1e50", "-1e50", "1e20", "1e-20", "1e-50"):
        with contextlib.suppress(CrackgrowError):
            solved_to_the_end(written(tmp_path, {key: value}))


def test_an_increment_far_larger_than_the_specimen_ends_at_its_outline() -> None:
    ends = []
    for increment in ("200 mm", "1e12 m", "1e50 m"):
        settings = ["growth.steps=1", f"growth.increment={increment}", "output.frames=none", "numerics.spacing=4"]
        *_, last = grow(shipped_case("compression30", settings))
        assert [event.kind for event in last.events] == ["break_through"]
        ends.append(last.cracks[0].points)
    assert len(ends[0]) == 3
    assert np.array_equal(ends[1], ends[0])
    assert np.array_equal(ends[2], ends[0])


@pytest.mark.parametrize(
    ("changes", "field"),
    [
        ({("loads", 2, "gravity", 1): "-1e59", ("bodies", "block", "material", "density"): "1e59"}, "loads"),
        (
            {("loads", 0, "traction", 1): "-1e53"}
            | {("bodies", body, "material", "young"): "1e-29" for body in ("block", "foundation", "plug")},
            "displacements",
        ),
        ({DISPLACEMENT: "1e59", ("loading", "history", 0): "1e20"}, "prescribed displacements"),
        ({DISPLACEMENT: '"1e300*y"', ("loading", "history", 0): "1e50"}, "prescribed displacements"),
    ],
    ids=["loads", "displacements", "prescribed displacements", "by a formula"],
)
def test_fields_that_leave_all_bounds_are_named(tmp_path: Path, changes: dict[Key, str], field: str) -> None:
    with pytest.raises(SolveError, match=f"^{field}.*: a value is .*wanted: finite, at most"):
        solved_to_the_end(written(tmp_path, changes))
