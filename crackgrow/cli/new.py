"""`crackgrow new`."""

from __future__ import annotations

import argparse
import shlex
from importlib.resources import files
from pathlib import Path
from typing import Final, TextIO

from crackgrow.cli.console import EXIT_DONE, say
from crackgrow.cli.parser import Commands, add_command
from crackgrow.errors import CaseError
from crackgrow.results.units import aligned

SCHEMA_FILE: Final = "case.schema.json"
"""What the JSON Schema is called where it lies beside cases."""

MODELINE: Final = f"# yaml-language-server: $schema={SCHEMA_FILE}\n"
"""First line of a case that tells editors where its schema is."""

_SUFFIX: Final = ".yaml"
_FOLDER: Final = files("crackgrow.cli") / "templates"

HELP = """\
Write a commented case to start from, as NAME.yaml into the folder `cases` if there is one, else here; a NAME with a
folder or with .yaml goes where it says. What exists is never overwritten.
"""
EXAMPLES = """\
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


def add(commands: Commands) -> None:
    known = templates()
    listed = "\n".join(aligned(known.items(), 2, "  "))
    texts = HELP, f"templates:\n{listed}\n\n{EXAMPLES}"
    command = add_command(commands, new, "new", "write a commented case to start from", texts)
    command.add_argument("name", metavar="NAME", help="the name of the case, or its file")
    command.add_argument(
        "--template", choices=tuple(known), default="compression", help="which one (default: compression)"
    )
