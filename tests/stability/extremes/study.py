"""Scenes at the extremes: `python -m tests.stability.extremes.study [--short] [--axis NAME ...] [--out DIR]`.

They are taken there one axis at a time and in some pairs, and held against references and invariants: stability.csv,
stability.md and stability.png. Verdicts: yes: within the tolerance; said: no good, or refused, and the program says so;
NO: neither. Exit code 4: a NO.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path

from crackgrow.cli.console import EXIT_DIFFERENT, EXIT_DONE
from crackgrow.results.atomic import write_text
from tests.stability.extremes import contact, material, place, units
from tests.stability.extremes.picture import draw
from tests.stability.extremes.scenes import Scenes
from tests.stability.extremes.table import csv_text, markdown_text
from tests.stability.extremes.trial import Row, Trial, evaluate, line_of

Axis = Callable[[Scenes], Iterator[Trial]]

AXES: dict[str, Axis] = {
    "stiffness": contact.stiffness,
    "friction": contact.friction,
    "cohesion": contact.cohesion,
    "young": units.young,
    "size": units.size,
    "load": units.load,
    "poisson": material.poisson,
    "contrast": material.contrast,
    "lattice": place.lattice,
    "tip": place.tip_next_to,
    "angle": place.angle,
    "length": place.length,
    "scene": place.scene,
    "stiffness-friction": contact.stiffness_and_friction,
    "size-young": units.size_and_young,
    "poisson-stiffness": material.poisson_and_stiffness,
}
"""Axes, pairs at the end."""


def rows_of(axes: Sequence[str] = (), *, short: bool = False) -> Iterator[Row]:
    """Rows of the axes asked for (default: all), each as soon as it is known; no row raises."""
    scenes = Scenes(short)
    for name in axes or AXES:
        for trial in AXES[name](scenes):
            yield evaluate(trial)


def write(folder: Path, rows: Sequence[Row]) -> None:
    """Write stability.csv, stability.md and stability.png into a folder, made where it is missing."""
    write_text(folder / "stability.csv", csv_text(rows))
    write_text(folder / "stability.md", markdown_text(rows))
    draw(folder / "stability.png", rows)


def main(argv: Sequence[str] | None = None) -> int:
    """Run the study and tell of each row."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--axis", nargs="+", choices=AXES, default=[], metavar="NAME", help="these axes alone")
    parser.add_argument("--short", action="store_true", help="coarse scenes, and few values of every axis")
    parser.add_argument("--out", type=Path, default=Path("outputs/stability"), metavar="DIR", help="where the files go")
    arguments = parser.parse_args(argv)
    rows = []
    for row in rows_of(arguments.axis, short=arguments.short):
        rows.append(row)
        print(line_of(row), flush=True)
    write(arguments.out, rows)
    n_bad = sum(row.verdict == "NO" for row in rows)
    print(f"{len(rows)} rows, {n_bad} NO\nresults in {arguments.out}")
    return EXIT_DIFFERENT if n_bad else EXIT_DONE


if __name__ == "__main__":
    sys.exit(main())
