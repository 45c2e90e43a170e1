"""The benchmark: `python -m tests.benchmarks.run` measures all runs and compares their ratios with the baseline.

Every run is measured in a process of its own, with its own floor, and is appended to history.csv; bench.md shows the
latest of each. Seconds are CPU seconds of one thread; on a shared machine even these are unsure, their ratios less so.
"""

from __future__ import annotations

import argparse
import os
import sys

from tests.benchmarks.compare import changes, comparison_text, load_baseline, store_baseline
from tests.benchmarks.fits import exponents, same_program
from tests.benchmarks.measure import in_own_process
from tests.benchmarks.paths import BASELINE, HERE, HISTORY
from tests.benchmarks.record import Measurement, append, latest, ratios, read
from tests.benchmarks.report import write_report
from tests.benchmarks.scenes import all_runs, chosen


def main() -> None:
    """Measure, print, keep."""
    options = _parser().parse_args()
    runs = chosen(options.only, options.quick, options.large)
    if not runs:
        sys.exit(f"no run to measure; there are: {', '.join(run.name for run in all_runs())}")
    done = []
    for run in runs:
        done.append(in_own_process(run))
        append(HISTORY, done[-1])
        print(_line(done[-1]), flush=True)
    write_report(HERE / "bench.md", in_order(latest(read(HISTORY))))
    now = {measured.run: ratios(measured) for measured in done}
    now["growth with size"] = {f"exponent of {name}": power for name, power in exponents(same_program(done)).items()}
    if options.baseline:
        store_baseline(BASELINE, {run: found for run, found in now.items() if found})
        print(f"stored as the baseline: {', '.join(run for run, found in now.items() if found)}")
    else:
        print(f"\n{comparison_text(changes(now, load_baseline(BASELINE)))}", end="")


def in_order(measurements: list[Measurement]) -> list[Measurement]:
    """As the runs are listed, without those that are no more."""
    by_name = {measured.run: measured for measured in measurements}
    return [by_name[run.name] for run in all_runs() if run.name in by_name]


def _line(m: Measurement) -> str:
    """One run at a glance."""
    return (
        f"{m.run:22s} {m.n_dofs:7d} unknowns {m.n_contact:4d} contact points   a step {1e3 * m.step:8.1f} ms   "
        f"step/floor {m.step / m.floor:5.2f}   {m.peak_MB:6.0f} MB"
    )


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(prog="make bench ARGS=...", description=__doc__)
    parser.add_argument("--only", metavar="TEXT", help="the runs whose name contains this")
    parser.add_argument("--quick", action="store_true", help="the runs that take a few seconds")
    parser.add_argument("--large", action="store_true", help="sizes up to 500,000 unknowns too: hours of cores, 20 GB")
    parser.add_argument("--baseline", action="store_true", help="store the ratios as the baseline")
    return parser


if __name__ == "__main__":
    for name in ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS"):  # of the processes that are measured
        os.environ[name] = "1"
    main()
