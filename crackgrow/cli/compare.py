"""`crackgrow compare`."""

from __future__ import annotations

import argparse

import crackgrow
from crackgrow.cli.console import EXIT_DIFFERENT, EXIT_DONE, hand_out_json, say
from crackgrow.cli.parser import Commands, add_command, path
from crackgrow.results.atomic import write_text

HELP = """\
Compare the crack paths of two result folders, or of a folder and a CSV file, crack by crack and tip by tip:
Hausdorff and Frechet distance of what has grown, distance of the tips, the place of the largest deviation.
"""
EXAMPLES = """\
A CSV has columns x and y in m, or x_mm and y_mm, and may have crack, vertex and step. Without step it may hold a
part of a path, such as one wing: then the part that both have is compared.

exit codes: 0 done; 2 or 3 a path cannot be read; 4 beyond the tolerance (1 in versions before this one).

examples:
  crackgrow compare outputs/before outputs/after --tolerance "0.15 mm"
  crackgrow compare outputs/compression30 paper.csv --crack flaw --tip end --columns x_mm_fem,y_mm
"""


def compare(arguments: argparse.Namespace) -> int:
    """`crackgrow compare`: how far apart the crack paths of two runs are."""
    from crackgrow.study.comparison_text import comparison_csv, comparison_record, comparison_text  # loads numpy

    comparison = crackgrow.compare_paths(
        arguments.a,
        arguments.b,
        tolerance=arguments.tolerance,
        crack=arguments.crack,
        tip=arguments.tip,
        columns=arguments.columns,
    )
    if arguments.json:
        hand_out_json(comparison_record(comparison))
    else:
        say(comparison_text(comparison))
    if arguments.csv is not None:
        write_text(arguments.csv, comparison_csv(comparison))
    return EXIT_DONE if comparison.agrees else EXIT_DIFFERENT


def add(commands: Commands) -> None:
    what = "say how far apart the crack paths of two runs are"
    command = add_command(commands, compare, "compare", what, (HELP, EXAMPLES))
    for name in ("a", "b"):
        command.add_argument(name, metavar=name.upper(), help="a result folder or a CSV file")
    command.add_argument(
        "--tolerance", metavar="LENGTH", help='largest distance allowed: "0.15 mm", or a bare number in m'
    )
    command.add_argument("--csv", type=path, metavar="FILE", help="write the rows of the table, SI, to a file")
    command.add_argument("--json", action="store_true", help="print all of it as JSON, SI, in place of the table")
    command.add_argument("--crack", metavar="NAME", help="compare this crack alone")
    command.add_argument("--tip", choices=("start", "end"), help="compare what has grown at this tip alone")
    command.add_argument("--columns", type=_two_names, metavar="X,Y", help="columns of x and y of a CSV with several")


def _two_names(text: str) -> tuple[str, ...]:
    names = tuple(name.strip() for name in text.split(","))
    if len(names) != 2 or not all(names):
        raise argparse.ArgumentTypeError(f"{text!r}: two column names are wanted, that of x and that of y: X,Y")
    return names
