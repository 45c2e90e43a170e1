"""What becomes of random scenes that grow, judged from their files alone.

    python -m tests.stability.growth_report --scenes 400 --processes 2

runs the scenes with seeds 0 to 399, each by the command line, into outputs/growth/<seed>, and appends what came of
each to outputs/growth/scenes.jsonl. Started again it goes on with the scenes that are missing there; `--judge` judges
the folders again without running anything. At the end, and with `--table` alone, it prints the tables: how scenes
ended, and for every kind of check how many were made, how many departures the run had told of, and how many it had
not, with the worst of these. The scene itself is outputs/growth/<seed>.yaml.

Exit code: 1 if something was wrong without a word, else 0.
"""

from __future__ import annotations

import argparse
import collections
import dataclasses
import json
import shutil
import sys
from collections.abc import Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor, as_completed
from pathlib import Path
from typing import Any

from tests.stability.growing_scenes import KINDS, growing_scene
from tests.stability.judge.verdict import judged, outcome
from tests.stability.judge.written import WrittenRun, read_run, run_case
from tests.stability.random_scenes import text_of

Record = dict[str, Any]

LEFT = ("frames", "cracks", "figures", "checkpoint")
"""Folders of a run that nothing is judged by."""


def record_of(seed: int, run: WrittenRun) -> Record:
    """One line of the results."""
    court = judged(run)
    last = run.errors.strip().splitlines()[-1:] or [""]
    return {
        "seed": seed,
        "kind": KINDS[seed % len(KINDS)],
        "outcome": outcome(run),
        "reason": run.summary.get("stop_reason") or last[0][:300],
        "exit_code": run.exit_code,
        "errors": run.errors,
        "seconds": round(run.seconds, 2),
        "steps": len(run.tables["steps"]) if "steps" in run.tables else 0,
        "warnings": len(run.summary.get("warnings", [])),
        "judged": dict(court.judged),
        "departures": [dataclasses.asdict(departure) for departure in court.departures],
    }


def run_scene(seed: int, folder: Path, limit: float) -> Record:
    """Run one scene and judge it."""
    file, out = folder / f"{seed}.yaml", folder / str(seed)
    file.write_text(text_of(growing_scene(seed)), encoding="utf-8")
    shutil.rmtree(out, ignore_errors=True)
    run = run_case(file, out, limit)
    for name in LEFT:
        shutil.rmtree(out / name, ignore_errors=True)
    return record_of(seed, run)


def run_scenes(seeds: Sequence[int], given: argparse.Namespace) -> Iterator[Record]:
    """Records as scenes end, several run at a time; Ctrl-C leaves the others for the next time."""
    with ThreadPoolExecutor(given.processes) as pool:
        futures = [pool.submit(run_scene, seed, given.out, given.limit) for seed in seeds]
        try:
            for future in as_completed(futures):
                yield future.result()
        except KeyboardInterrupt:
            pool.shutdown(cancel_futures=True)


def judge_again(folder: Path, before: Sequence[Record]) -> Iterator[Record]:
    """The records of runs that are there, judged anew."""
    for old in before:
        run = read_run(folder / str(old["seed"]), old["exit_code"], old["errors"], old["seconds"])
        yield record_of(old["seed"], run)


def n_silent(record: Record) -> int:
    """Departures that the run has not told of."""
    return sum(not departure["told"] for departure in record["departures"])


def read_records(file: Path) -> list[Record]:
    """What was judged before."""
    if not file.is_file():
        return []
    return [json.loads(line) for line in file.read_text(encoding="utf-8").splitlines() if line.strip()]


def print_tables(records: Sequence[Record]) -> None:
    """How scenes ended by kind, then every check."""
    ends = sorted({record["outcome"] for record in records})
    print(f"| scenes | number | {' | '.join(ends)} | steps | median s |\n|{'---|' * (len(ends) + 4)}")
    for kind in (*KINDS, "all"):
        some = [record for record in records if kind in (record["kind"], "all")]
        if some:
            counts = collections.Counter(record["outcome"] for record in some)
            middle = sorted(record["seconds"] for record in some)[len(some) // 2]
            steps = sum(record["steps"] for record in some)
            numbers = " | ".join(str(counts[end]) for end in ends)
            print(f"| {kind} | {len(some)} | {numbers} | {steps} | {middle:.1f} |")
    made: collections.Counter[str] = collections.Counter()
    for record in records:
        made.update(record["judged"])
    print("\n| check | made | departures told of | without a word | scenes of these | worst | seed, step, place |")
    print("|---|---|---|---|---|---|---|")
    for kind in made:
        found = [(d, record["seed"]) for record in records for d in record["departures"] if d["kind"] == kind]
        silent = [(d, seed) for d, seed in found if not d["told"]]
        worst, where = "", ""
        if silent:
            departure, seed = max(silent, key=lambda item: item[0]["size"])
            worst, where = f"{departure['size']:.2g}", f"{seed}, {departure['step']}, {departure['place']}"
        scenes = len({seed for _, seed in silent})
        print(f"| {kind} | {made[kind]} | {len(found) - len(silent)} | {len(silent)} | {scenes} | {worst} | {where} |")
    print("\nunsolved, refused, crashed or not done in time:")
    for record in records:
        if record["outcome"] in ("unsolved", "refused", "crashed", "failed", "time limit"):
            print(f"{record['seed']:5d} {record['kind']:10s} {record['outcome']}: {record['reason']}")


def options(name: str, text: str | None, scenes: int) -> argparse.ArgumentParser:
    """What reports of random scenes are asked: which scenes, for how long, where to; or the tables alone."""
    parser = argparse.ArgumentParser(
        prog=f"python -m tests.stability.{name}",
        description=text,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    out = Path("outputs") / name.removesuffix("_report")
    parser.add_argument("--scenes", type=int, default=scenes, help=f"how many (default {scenes})")
    parser.add_argument("--seed", type=int, default=0, help="the first one's seed (default 0)")
    parser.add_argument("--limit", type=float, default=40.0, help="seconds of CPU that a run may take (default 40)")
    parser.add_argument("--out", type=Path, default=out, help=f"folder (default {out})")
    parser.add_argument("--table", action="store_true", help="print the tables of what is there, run nothing")
    return parser


def main() -> int:
    """Run what is missing, and tell."""
    parser = options("growth_report", __doc__, 400)
    parser.add_argument("--processes", type=int, default=1, help="runs at a time (default 1)")
    parser.add_argument("--judge", action="store_true", help="judge the folders again, run nothing")
    given = parser.parse_args()
    given.out.mkdir(parents=True, exist_ok=True)
    file = given.out / "scenes.jsonl"
    records = read_records(file)
    if given.judge:
        records = list(judge_again(given.out, records))
        file.write_text("".join(json.dumps(record) + "\n" for record in records), encoding="utf-8")
    elif not given.table:
        done = {record["seed"] for record in records}
        missing = [seed for seed in range(given.seed, given.seed + given.scenes) if seed not in done]
        with file.open("a", encoding="utf-8") as results:
            for record in run_scenes(missing, given):
                results.write(json.dumps(record) + "\n")
                results.flush()
                records.append(record)
                ended = f"{record['outcome']}, {record['seconds']} s, {n_silent(record)} departures without a word"
                print(f"{record['seed']} {record['kind']}: {ended}", flush=True)
    print_tables(records)
    return int(any(map(n_silent, records)))


if __name__ == "__main__":
    sys.exit(main())
