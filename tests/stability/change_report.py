"""Whether random scenes that grow give the same results when they are written otherwise.

    python -m tests.stability.change_report --scenes 40

runs the scenes with seeds 0 to 39 as they are, turned by 90 degrees, mirrored, in other units, scaled, with cracks in
another order, reversed, and with a vertex more on their first segments, each by the command line, into
outputs/change/<seed>, and appends how far K, paths and load factors are apart to outputs/change/scenes.jsonl.
Started again it goes on with what is missing. At the end, and with `--table` alone, it prints the table.

Exit code: 1 if a deviation is beyond 1e-6, else 0.
"""

from __future__ import annotations

import dataclasses
import json
import shutil
import sys
from collections.abc import Sequence
from pathlib import Path

from tests.stability.changed_scenes import CHANGES, TOLERANCE, deviations
from tests.stability.growing_scenes import KINDS, growing_scene
from tests.stability.growth_report import Record, options, read_records
from tests.stability.judge.written import run_case
from tests.stability.random_scenes import text_of


def compare(seed: int, folder: Path, limit: float) -> list[Record]:
    """A scene and all that it can be changed to."""
    place = folder / str(seed)
    shutil.rmtree(place, ignore_errors=True)
    place.mkdir(parents=True)
    scene, runs = growing_scene(seed), {}
    for name, document in {"as it is": scene, **{change.name: change.apply(scene) for change in CHANGES}}.items():
        file = place / f"{name}.yaml"
        file.write_text(text_of(document), encoding="utf-8")
        runs[name] = run_case(file, place / name, limit)
        shutil.rmtree(place / name / "checkpoint", ignore_errors=True)
    first = runs["as it is"]
    return [
        {
            "seed": seed,
            "kind": KINDS[seed % len(KINDS)],
            "change": change.name,
            "status": first.summary.get("status", "refused"),
            "steps": len(first.tables.get("steps", ())),
            **dataclasses.asdict(found := deviations(first, runs[change.name], change)),
            "within": bool(found.largest <= TOLERANCE),
        }
        for change in CHANGES
    ]


def print_table(records: Sequence[Record]) -> None:
    """Change by change, then what is beyond."""
    print("| change | scenes | steps | within | ended otherwise | largest at step 0, K | K | path | load factor |")
    print("|---|---|---|---|---|---|---|---|---|")
    for change in CHANGES:
        some = [record for record in records if record["change"] == change.name]
        alike = [record for record in some if not record["ended"]]
        worst = [
            max((r[key] for r in alike if r[key] == r[key]), default=0.0) for key in ("K_first", "K", "path", "factor")
        ]
        sizes = " | ".join(f"{value:.1e}" for value in worst)
        within, steps = sum(record["within"] for record in some), sum(record["steps"] for record in some)
        print(f"| {change.name} | {len(some)} | {steps} | {within} | {len(some) - len(alike)} | {sizes} |")
    print("\nbeyond 1e-6:")
    for r in records:
        if not r["within"]:
            sizes = ", ".join(f"{key} {r[key]:.1e}" for key in ("K_first", "K", "path", "factor"))
            print(f"{r['seed']:5d} {r['kind']:10s} {r['change']}: {sizes} {r['ended']}")


def main() -> int:
    """Run what is missing, and tell."""
    given = options("change_report", __doc__, 40).parse_args()
    given.out.mkdir(parents=True, exist_ok=True)
    file = given.out / "scenes.jsonl"
    records = read_records(file)
    done = {record["seed"] for record in records}
    for seed in () if given.table else range(given.seed, given.seed + given.scenes):
        if seed in done:
            continue
        found = compare(seed, given.out, given.limit)
        with file.open("a", encoding="utf-8") as results:
            results.writelines(json.dumps(record) + "\n" for record in found)
        records += found
        print(f"{seed}: {sum(not record['within'] for record in found)} beyond", flush=True)
    print_table(records)
    return int(not all(record["within"] for record in records))


if __name__ == "__main__":
    sys.exit(main())
