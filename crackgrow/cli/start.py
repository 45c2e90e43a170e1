"""The commands that one starts with: `crackgrow list`, `new` and `check`."""

from __future__ import annotations

import shlex
from collections.abc import Callable, Iterator
from importlib.resources import files
from pathlib import Path
from typing import Final

from crackgrow.cli.command_line import declared
from crackgrow.cli.console import hand_out, hand_out_json, load_case_file, say
from crackgrow.errors import CaseError
from crackgrow.results.units import aligned

SCHEMA_FILE: Final = "case.schema.json"
"""What the JSON Schema is called where it lies beside cases."""

MODELINE: Final = f"# yaml-language-server: $schema={SCHEMA_FILE}\n"
"""First line of a case that tells editors where its schema is."""


def do_list(folder: Path | None) -> None:
    """`crackgrow list`: what there is to run, and to start from."""
    if folder is not None and not folder.is_dir():
        raise CaseError.at(folder, "is no folder")
    folder = folder or Path("cases")
    lines = [*_listed(folder, "cases", "run"), *_listed(folder / "sweeps", "sweeps", "sweep")]
    lines += _listed(folder / "fits", "fits", "fit")
    templates = declared()["words"]["templates"]
    lines += ["templates: crackgrow new NAME --template ...", *aligned(templates.items(), 2, "  ")]
    hand_out("\n".join(lines) + "\n")


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
        title = next((line for line in lines if line.startswith("title:")), None)
        if title is not None:
            return str(yaml.safe_load(title)["title"])
    except (OSError, UnicodeDecodeError):
        return "(cannot be read)"
    except yaml.YAMLError:
        return ""
    return lines[0].removeprefix("#").strip() if lines and lines[0].startswith("#") else ""


def do_new(name: str, template: str) -> None:
    """Run `crackgrow new`: write a template as a new case file, in cases/ if there is such a folder."""
    file = _file_of(name)
    text = template_text(template)
    if (file.parent / SCHEMA_FILE).is_file():
        text = MODELINE + text
    try:
        if not file.parent.is_dir():
            file.parent.mkdir(parents=True)
        with file.open("x", encoding="utf-8") as stream:
            try:
                stream.write(text)
                stream.close()  # what was buffered is on disk only now
            except BaseException:
                file.unlink()  # half of a case is not left behind
                raise
    except (OSError, ValueError) as error:  # ValueError: a null character in the name
        message = f"cannot be written: {getattr(error, 'strerror', None) or error}"
        if isinstance(error, FileExistsError) and file.exists():
            message = "exists already, and is left as it is"
        raise CaseError.at(file, message) from None
    quoted = shlex.quote(str(file))
    say(f"wrote {file}\nnext: crackgrow check {quoted}, then crackgrow run {quoted}")


def template_text(name: str) -> str:
    """The text of a template."""
    return (files("crackgrow.cli") / "templates" / f"{name}.yaml").read_text(encoding="utf-8")


def _file_of(name: str) -> Path:
    path = Path(name)
    if not path.name:
        raise CaseError.at(repr(name), "is no name of a case; allowed are those such as my_slope")
    if path.suffix in (".yaml", ".yml"):
        return path
    folder = Path("cases")
    return (folder if path.parent == Path() and folder.is_dir() else path.parent) / f"{path.name}.yaml"


def do_check(case: Path, overrides: list[str], picture: Path | None, as_json: bool, unique: bool) -> None:
    """`crackgrow check`: validate a case, say what it models, and draw it if asked to."""
    model = load_case_file(case, overrides)
    from crackgrow.plan.text import plan_record, plan_text  # only now: it loads numpy

    tell: Callable[[str], None] = (lambda text: None) if as_json else say
    record = plan_record(model) if as_json else {}
    if not as_json:
        say(plan_text(model))
    if picture is not None:
        from crackgrow.plan.cost import squares_of
        from crackgrow.results.drawing import draw_scene  # only now: it loads matplotlib

        draw_scene(picture, model, squares_of(model))
        tell(f"picture in {picture}")
    if unique:
        from crackgrow.run.uniqueness import unique_text  # only now: it loads the solver

        tell("\nsolutions of the contact")
        record["unique"] = told = []
        for line in unique_text(model):  # each is told as soon as it is there
            tell(line)
            told.append(line)
    if as_json:
        hand_out_json(record)
