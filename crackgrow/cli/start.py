"""The commands that one starts with: `crackgrow list`, `new`, `check` and `explain`."""

from __future__ import annotations

import argparse
import shlex
import shutil
from collections.abc import Callable, Iterable, Iterator
from importlib.resources import files
from pathlib import Path
from typing import Final, TextIO

from crackgrow.cli.console import EXIT_DONE, hand_out, hand_out_json, say
from crackgrow.cli.parser import Commands, add_command, load_case_file, path, takes_case
from crackgrow.errors import CaseError
from crackgrow.results.units import aligned

LIST_HELP = "List the cases of a folder with their titles, its sweeps, and the templates of `crackgrow new`."
LIST_EXAMPLES = """\
examples:
  crackgrow list
  crackgrow list studies/shear
"""


def list_cases(arguments: argparse.Namespace) -> int:
    """`crackgrow list`: what there is to run, and to start from."""
    folder: Path = arguments.folder or Path("cases")
    if arguments.folder is not None and not folder.is_dir():
        raise CaseError.at(folder, "is no folder")
    lines = [*_listed(folder, "cases", "run"), *_listed(folder / "sweeps", "sweeps", "sweep")]
    lines += ["templates: crackgrow new NAME --template ...", *aligned(templates().items(), 2, "  ")]
    hand_out("\n".join(lines) + "\n")
    return EXIT_DONE


def _listed(folder: Path, what: str, command: str) -> Iterator[str]:
    """A line for each YAML file of a folder, if there are any."""
    files = sorted(folder.glob("*.yaml"))
    if files:
        yield f"{what} in {folder}: crackgrow {command} FILE"
        yield from aligned([(str(file), _title(file)) for file in files], 2, "  ")


def _title(file: Path) -> str:
    """The title of a case, or the comment at the top; nothing where neither is a line that can be read."""
    import yaml  # here: the other commands need none of it

    try:
        lines = file.read_text(encoding="utf-8").splitlines()
    except (OSError, UnicodeDecodeError):
        return "(cannot be read)"
    for line in lines:
        if line.startswith("title:"):
            try:
                return str(yaml.safe_load(line)["title"])
            except yaml.YAMLError:
                return ""
    return lines[0].removeprefix("#").strip() if lines and lines[0].startswith("#") else ""


def add_list(commands: Commands) -> None:
    what = "list the cases that are here, and the templates"
    command = add_command(commands, list_cases, "list", what, (LIST_HELP, LIST_EXAMPLES))
    command.add_argument("folder", nargs="?", type=path, metavar="DIR", help="a folder of cases (default: cases)")


SCHEMA_FILE: Final = "case.schema.json"
"""What the JSON Schema is called where it lies beside cases."""

MODELINE: Final = f"# yaml-language-server: $schema={SCHEMA_FILE}\n"
"""First line of a case that tells editors where its schema is."""

_SUFFIX: Final = ".yaml"
_FOLDER: Final = files("crackgrow.cli") / "templates"

NEW_HELP = """\
Write a commented case to start from, as NAME.yaml into the folder `cases` if there is one, else here; a NAME with a
folder or with .yaml goes where it says. What exists is never overwritten.
"""
NEW_EXAMPLES = """\
examples:
  crackgrow new my_slope
  crackgrow new studies/shear --template interface
  crackgrow check cases/my_slope.yaml
"""


def templates() -> dict[str, str]:
    """What each template is, in a line, by its name."""
    names = sorted(file.name.removesuffix(_SUFFIX) for file in _FOLDER.iterdir() if file.name.endswith(_SUFFIX))
    return {name: template_text(name).splitlines()[0].removeprefix("# ") for name in names}


def template_text(name: str) -> str:
    """The text of a template; its name must be one of `templates`."""
    return (_FOLDER / f"{name}{_SUFFIX}").read_text(encoding="utf-8")


def new(arguments: argparse.Namespace) -> int:
    """`crackgrow new`: write a case to start from."""
    file = _file_of(arguments.name)
    text = template_text(arguments.template)
    if (file.parent / SCHEMA_FILE).is_file():
        text = MODELINE + text
    try:
        if not file.parent.is_dir():
            file.parent.mkdir(parents=True)
        with file.open("x", encoding="utf-8") as stream:
            _write_or_remove(stream, text, file)
    except (OSError, ValueError) as error:  # ValueError: a null character in the name
        message = f"cannot be written: {getattr(error, 'strerror', None) or error}"
        if isinstance(error, FileExistsError) and file.exists():
            message = "exists already, and is left as it is"
        raise CaseError.at(file, message) from None
    quoted = shlex.quote(str(file))
    say(f"wrote {file}\nnext: crackgrow check {quoted}, then crackgrow run {quoted}")
    return EXIT_DONE


def _write_or_remove(stream: TextIO, text: str, file: Path) -> None:
    """Write and close a new file; where that fails, half of a case is not left behind."""
    try:
        stream.write(text)
        stream.close()  # what was buffered is on disk only now
    except BaseException:
        file.unlink()
        raise


def _file_of(name: str) -> Path:
    path = Path(name)
    if not path.name:
        raise CaseError.at(repr(name), "is no name of a case; allowed are those such as my_slope")
    if path.suffix in (".yaml", ".yml"):
        return path
    folder = Path("cases")
    return (folder if path.parent == Path() and folder.is_dir() else path.parent) / f"{path.name}.yaml"


def add_new(commands: Commands) -> None:
    known = templates()
    listed = "\n".join(aligned(known.items(), 2, "  "))
    texts = NEW_HELP, f"templates:\n{listed}\n\n{NEW_EXAMPLES}"
    command = add_command(commands, new, "new", "write a commented case to start from", texts)
    command.add_argument("name", metavar="NAME", help="the name of the case, or its file")
    command.add_argument(
        "--template", choices=tuple(known), default="compression", help="which one (default: compression)"
    )


CHECK_HELP = """\
Validate a case and print the plan of its run: bodies, cracks and tips, what is modelled and why, the unknowns of the
first step, counted on its cover, what the whole run costs in seconds and memory, and what to beware of. Nothing is
solved unless --unique asks whether friction leaves the contact one solution at every load factor.
"""
CHECK_EXAMPLES = """\
exit codes: 0 the case can be run; 2 it is wrong, all faults are listed; 3 its cracks cannot be covered, or with
--unique its loads not be solved.

examples:
  crackgrow check cases/compression30.yaml
  crackgrow check cases/two_flaws.yaml --set numerics.accuracy=fine --picture two_flaws.svg
  crackgrow check cases/confined30.yaml --unique
"""


def check(arguments: argparse.Namespace) -> int:
    """`crackgrow check`: validate a case, say what it models, and draw it if asked to."""
    case = load_case_file(arguments)
    from crackgrow.plan.text import plan_record, plan_text  # only now: it loads numpy

    tell = (lambda text: None) if arguments.json else say
    record = plan_record(case) if arguments.json else {}
    if not arguments.json:
        say(plan_text(case))
    if arguments.picture is not None:
        from crackgrow.plan.cost import squares_of
        from crackgrow.results.drawing import draw_scene  # only now: it loads matplotlib

        draw_scene(arguments.picture, case, squares_of(case))
        tell(f"picture in {arguments.picture}")
    if arguments.unique:
        from crackgrow.run.uniqueness import unique_text  # only now: it loads the solver

        tell("\nsolutions of the contact")
        record["unique"] = list(_told(unique_text(case), tell))
    if arguments.json:
        hand_out_json(record)
    return EXIT_DONE


def _told(lines: Iterable[str], tell: Callable[[str], None]) -> Iterator[str]:
    """The same lines, each told as soon as it is there."""
    for line in lines:
        tell(line)
        yield line


def add_check(commands: Commands) -> None:
    what = "validate a case, say what it models and costs"
    command = takes_case(add_command(commands, check, "check", what, (CHECK_HELP, CHECK_EXAMPLES)))
    command.add_argument("--picture", type=_picture, metavar="FILE.png|svg", help="draw the scene, too")
    command.add_argument("--json", action="store_true", help="print the plan as JSON")
    command.add_argument(
        "--unique", action="store_true", help="solve the first step: does friction leave one solution?"
    )


def _picture(text: str) -> Path:
    path = Path(text)
    if path.suffix.lower() not in (".png", ".svg"):
        raise argparse.ArgumentTypeError(f"{text!r}: a name that ends in .png or .svg is wanted")
    return path


EXPLAIN_HELP = """\
Say what a key of a case means, its type, unit, default and what is allowed; or what a word means that a key takes; or
what is in a file or column of the results. Without a name: the first keys of a case and the files of a run.
"""
EXPLAIN_EXAMPLES = """\
examples:
  crackgrow explain numerics.spacing
  crackgrow explain cracks                 # with all keys below it
  crackgrow explain friction               # every key of that name
  crackgrow explain loading.critical       # a word that a key takes
  crackgrow explain tips.csv
  crackgrow explain K_II
"""


def explain_name(arguments: argparse.Namespace) -> int:
    """`crackgrow explain`: print what is to be known of a key, a file or a column."""
    from crackgrow.cli.reference import explain, first_entries, nearest  # only now: they load numpy

    name: str = arguments.name
    found = explain(name) if name else first_entries()
    if not found:
        near = nearest(name)
        hint = f"; did you mean {' or '.join(near)}?" if near else "; `crackgrow explain` lists what there is"
        raise CaseError.at("explain", f"is no key of a case, file or column of results{hint}", name)
    width = shutil.get_terminal_size().columns
    hand_out("\n".join(line for entry in found for line in entry.lines(width, None if name else 1)) + "\n")
    return EXIT_DONE


def add_explain(commands: Commands) -> None:
    what = "say what a key of a case, or a column of the results, means"
    command = add_command(commands, explain_name, "explain", what, (EXPLAIN_HELP, EXPLAIN_EXAMPLES))
    command.add_argument(
        "name", nargs="?", default="", metavar="KEY|COLUMN", help="a key, a word that keys take, a file or a column"
    )
