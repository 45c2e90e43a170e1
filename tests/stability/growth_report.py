"""What becomes of random scenes that grow, judged from their files alone.

    python -m tests.stability.growth_report --scenes 400 --processes 2

runs the scenes with seeds 0 to 399, each by the command line, into outputs/growth/<seed>, and prints how scenes ended,
and for every kind of check how many were made, how many departures the run had told of, and how many it had not, with
the worst of these. The scene itself is outputs/growth/<seed>.yaml. Exit code: 1 if something was wrong without a word.
"""

from __future__ import annotations

import argparse
import collections
import shutil
import sys
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

from tests.stability.growing_scenes import KINDS, growing_scene
from tests.stability.judge.court import Court
from tests.stability.judge.verdict import judged, outcome
from tests.stability.judge.written import run_case
from tests.stability.random_scenes import text_of

LEFT = ("frames", "cracks", "figures", "checkpoint")
"""Folders of a run that nothing is judged by."""


def run_scene(seed: int, folder: Path, limit: float) -> tuple[int, str, Court]:
    """Run one scene and judge it."""
    file, out = folder / f"{seed}.yaml", folder / str(seed)
    file.write_text(text_of(growing_scene(seed)), encoding="utf-8")
    shutil.rmtree(out, ignore_errors=True)
    run = run_case(file, out, limit)
    for name in LEFT:
        shutil.rmtree(out / name, ignore_errors=True)
    return seed, outcome(run), judged(run)


def main() -> int:
    """Run the scenes, and tell."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--scenes", type=int, default=400, help="how many (default 400)")
    parser.add_argument("--seed", type=int, default=0, help="the first one's seed (default 0)")
    parser.add_argument("--limit", type=float, default=40.0, help="seconds of CPU that a run may take (default 40)")
    parser.add_argument("--processes", type=int, default=1, help="runs at a time (default 1)")
    given, folder = parser.parse_args(), Path("outputs") / "growth"
    folder.mkdir(parents=True, exist_ok=True)
    seeds = range(given.seed, given.seed + given.scenes)
    with ThreadPoolExecutor(given.processes) as pool:
        found = list(pool.map(lambda seed: run_scene(seed, folder, given.limit), seeds))
    ends = collections.Counter((KINDS[seed % len(KINDS)], end) for seed, end, _ in found)
    print("\n".join(f"| {kind} | {end} | {number} |" for (kind, end), number in sorted(ends.items())))
    print("\n| check | made | told of | without a word | worst: size, seed, step, place |\n|---|---|---|---|---|")
    made: collections.Counter[str] = collections.Counter()
    for _, _, court in found:
        made.update(court.judged)
    n_silent = 0
    for kind, number in made.items():
        departures = [(d.size, seed, d.step, d.place, d.told) for seed, _, court in found for d in court.departures
                      if d.kind == kind]  # fmt: skip
        silent = [departure for departure in departures if not departure[-1]]
        n_silent += len(silent)
        worst = max(silent, key=lambda departure: departure[0])[:4] if silent else ""
        print(f"| {kind} | {number} | {len(departures) - len(silent)} | {len(silent)} | {worst} |")
    return int(n_silent > 0)


if __name__ == "__main__":
    sys.exit(main())
