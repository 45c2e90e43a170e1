"""The golden table: what the shipped cases and the scenes of targets give, number by number.

    python -m tests.regression.test_golden [SCENE ...]            says what differs from the table
    python -m tests.regression.test_golden --update [SCENE ...]   writes the table anew, and says what has changed

A row is a scene, a step, a place, a quantity and its value. Of a run there are the first step and the last of at most
`MOST_STEPS`. It is no truth: references and exact solutions are in tests/verification. It holds results
while code is moved.
"""

from __future__ import annotations

import argparse
import csv
from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import crackgrow
from crackgrow.run.result import StepResult
from tests.benchmarks.target_scenes import SCENES
from tests.scenes import shipped_case

HERE = Path(__file__).parent
TABLE = HERE / "golden.csv"
CASES = HERE.parents[1] / "cases"
HEADER = ("scene", "step", "place", "quantity", "value")

MOST_STEPS = 3
LONGER = ("random_flaws", "joint_map", "confined30", "two_flaws_overlapping")
LONG = ("03_wings", "05_initiation", "06_slow_growth", "14_fatigue", "16_injection")
FEWER = dict.fromkeys(LONG, 2) | dict.fromkeys(LONGER, 1)
"""Steps of growth, by scene where they take long."""

SIZES: Mapping[str, str] = {
    **dict.fromkeys(("K_I", "K_II"), "K"),
    **dict.fromkeys(("work", "strain", "dissipated", "released"), "energy"),
    **dict.fromkeys(("force_x", "force_y"), "force"),
    **dict.fromkeys(("x", "y", "crack_length"), "length"),
}
"""Quantities that differ by a part of the largest of all of them in a scene; others by a part of the largest of their
own kind."""

NO_FORCE = 1e-9
"""Of the stress times the extent of the rock: a reaction below is round-off of loads that balance."""

Key = tuple[str, str, str, str]
Rows = dict[Key, float]


def of_case(name: str) -> Rows:
    """What a shipped case gives."""
    growth, most = shipped_case(name).growth, FEWER.get(name, MOST_STEPS)
    case = shipped_case(name, [f"growth.steps={most}"] if growth is not None and growth.steps > most else ())
    run, extent = crackgrow.run_case(case), np.ptp(np.concatenate([body.outline for body in case.bodies]), axis=0).max()
    last = len(run.results) - 1
    told = [_of_step(name, run.results[step], extent) for step in sorted({0, last})]
    rows = {key: value for step in told for key, value in step}
    for number, event in enumerate((*(e for result in run.results for e in result.events), *run.end.events)):
        place = f"{number}: {event.kind} of {event.crack} {event.tip} with {event.met}"
        rows[name, str(event.step), place, "x"], rows[name, str(event.step), place, "y"] = map(float, event.point)
    rows[name, "end", run.status, "steps"] = float(last)
    if run.end.safety is not None:
        rows[name, "end", "safety", "factor"] = run.end.safety.factor
    return rows


def _of_step(name: str, result: StepResult, extent: float) -> Iterator[tuple[Key, float]]:
    """Rows of a step in rock of an extent (m); what is not known is left out."""
    by_place: list[tuple[str, dict[str, float]]] = [
        ("", {"load_factor": result.load_factor, "crack_length": result.crack_length}),
        ("", {part: getattr(result.energy, part) for part in ("work", "strain", "dissipated", "released")}),
    ]
    for tip in result.tips:
        (x, y), kink, criticality = tip.point, np.deg2rad(tip.kink_deg), tip.criticality
        by_place.append((f"{tip.crack} {tip.tip}", {"x": x, "y": y, "K_I": tip.K_I, "K_II": tip.K_II}))
        by_place.append((f"{tip.crack} {tip.tip}", {"kink": kink, "criticality": criticality}))
    by_place += [(f"{tip.crack} {tip.tip}", {"G": tip.G}) for tip in result.interface_tips]
    for reaction in result.reactions:
        force = [part if abs(part) > NO_FORCE * result.stress * extent else 0.0 for part in reaction.force]
        by_place.append((reaction.where, dict(zip(("force_x", "force_y"), force, strict=True))))
    for place, values in by_place:
        for quantity, value in values.items():
            if np.isfinite(value):
                yield (name, str(result.step), place, quantity), float(value)


def of_target_scene(name: str) -> Rows:
    """K of a scene of the targets, on cells of `draft`."""
    case = crackgrow.Case.from_dict({**SCENES[name]().case, "numerics": {"accuracy": "draft"}})
    tips = crackgrow.solve(case).tips
    return {
        (name, "0", f"{row['crack']} {row['tip']}", quantity): float(row[quantity])
        for _, row in tips.iterrows()
        for quantity in ("K_I", "K_II")
        if np.isfinite(row[quantity])
    }


MAKERS: Mapping[str, Callable[[], Rows]] = {
    **{path.stem: partial(of_case, path.stem) for path in sorted(CASES.glob("*.yaml"))},
    **{name: partial(of_target_scene, name) for name in SCENES if name != "fifty flaws"},  # of random_flaws
}
"""By scene."""


def table() -> dict[str, Rows]:
    """The rows of the table by scene."""
    found: dict[str, Rows] = {}
    with TABLE.open(newline="", encoding="utf-8") as file:
        for scene, step, place, quantity, value in list(csv.reader(file))[1:]:
            found.setdefault(scene, {})[scene, step, place, quantity] = float(value)
    return found


def differences(old: Rows, new: Rows) -> list[tuple[float, str]]:
    """What differs between the rows of a scene, the largest first: by how much of its size, and in words.

    The kink of a tip with a small K is known less well, by as much as that is smaller than the largest.
    """
    largest = {"kink": 1.0}  # rad
    for (*_, quantity), value in old.items():
        kind = SIZES.get(quantity, quantity)
        largest[kind] = max(largest.get(kind, 0.0), abs(value))
    found = []
    for key in sorted({*old, *new}):
        before, after = old.get(key), new.get(key)
        if before is None or after is None:
            found.append((np.inf, f"{', '.join(key)}: {before} -> {after}"))
        elif before != after:
            size = largest[SIZES.get(key[-1], key[-1])] or abs(after)
            if key[-1] == "kink" and (K := np.hypot(*(old.get((*key[:-1], mode), 0.0) for mode in ("K_I", "K_II")))):
                size *= largest["K"] / K
            found.append((abs(after - before) / size, f"{', '.join(key)}: {before!r} -> {after!r}"))
    return sorted(found, reverse=True)


ROUND_OFF = 1e-8
"""Of the size of a quantity: other processors and BLAS change the last digits, and growth carries them on."""


@pytest.mark.parametrize("scene", MAKERS)
def test_results_are_those_of_the_table(scene: str) -> None:
    assert [words for size, words in differences(table()[scene], MAKERS[scene]()) if size > ROUND_OFF] == []


def main(given: Sequence[str] | None = None) -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("scenes", nargs="*", metavar="SCENE", help="all of them unless some are named")
    parser.add_argument("--update", action="store_true", help="write the table anew")
    parser.add_argument("--tolerance", type=float, default=1e-12, help="of the size of a quantity (default: 1e-12)")
    asked: Any = parser.parse_args(given)
    kept = table() if TABLE.exists() else {}
    for scene in asked.scenes or MAKERS:
        new = MAKERS[scene]()
        differing = differences(kept.get(scene, {}), new)
        beyond = [words for size, words in differing if size > asked.tolerance]
        worst = f", the largest by {differing[0][0]:.1e}" if differing else ""
        print(f"{scene}: {len(new)} values, {len(beyond)} differ by more than {asked.tolerance:g}{worst}", flush=True)
        print("".join(f"    {words}\n" for words in beyond[:5]), end="", flush=True)
        kept[scene] = new
    if asked.update:
        with TABLE.open("w", newline="", encoding="utf-8") as file:
            writer = csv.writer(file, lineterminator="\n")
            writer.writerow(HEADER)
            for scene in MAKERS:
                writer.writerows((*key, repr(value)) for key, value in kept.get(scene, {}).items())


if __name__ == "__main__":
    main()
