"""YAML text -> a tree of nodes that know their line. Nothing is constructed: a scalar stays text."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path as FilePath
from typing import Any, NoReturn

import yaml

from crackgrow.case.report import Path, Place, Report, clean, quoted

MAX_DEPTH = 40  # of nested lists and mappings; the format needs 7
TOO_DEEP = f"nested deeper than {MAX_DEPTH} levels"
MAX_BYTES = 2**19  # its text takes two or three seconds to read
MAX_COPIES = 100_000  # of values that stand for aliases

_CORE = "tag:yaml.org,2002:"
NO_TAG = ""
UNKNOWN = "alias without an anchor"
_SCALAR_TAGS = {NO_TAG, "int", "float", "bool", "null"}


@dataclass(slots=True)
class Scalar:
    """A single value, as text; `plain` means that it was written without quotes."""

    text: str
    plain: bool
    place: Place

    @property
    def is_null(self) -> bool:
        """Whether no value was given."""
        return self.plain and self.text in ("", "~", "null", "Null", "NULL")


@dataclass(slots=True)
class Listing:
    """A list."""

    items: list[Node]
    place: Place


@dataclass(slots=True)
class Entry:
    """One key with its value; `implied` if an override made it only on the way to a key inside it."""

    place: Place
    node: Node
    implied: bool = False


@dataclass(slots=True)
class Table:
    """A mapping."""

    entries: dict[str, Entry]
    place: Place


@dataclass(slots=True)
class Broken:
    """A value whose fault has been reported already."""

    place: Place


Node = Scalar | Listing | Table | Broken


class _Stop(Exception):  # noqa: N818  (no error: the reason is in the report)
    """The rest of the text cannot be read."""


def read_file(file: str | FilePath, report: Report) -> Node | None:
    """Return the node tree of a case file, or None if it cannot be read; faults go to the report."""
    path, line, n_faults = FilePath(file), None, len(report.faults)
    try:
        if not path.exists():
            problem = "no such file"
        elif path.is_dir():
            problem = "is a directory; a case is a YAML file"
        elif not path.is_file():
            problem = "is not a regular file"
        elif path.stat().st_size > MAX_BYTES:
            problem = f"is larger than {MAX_BYTES // 2**10} KiB; a case file is small"
        else:
            node = parse(path.read_bytes().decode("utf-8-sig"), report, Place(str(file), 1))
            if node is not None or len(report.faults) > n_faults:
                return node
            problem, line = "the file is empty", 1
    except UnicodeDecodeError as error:
        problem, line = "is not a text in UTF-8", error.object.count(b"\n", 0, error.start) + 1
    except (OSError, ValueError) as error:  # ValueError: a null character in the name
        problem = f"cannot be read: {getattr(error, 'strerror', None) or error}"
    report.fault((), problem, Place(str(file), line))
    return None


def parse(text: str, report: Report, start: Place, path: Path = ()) -> Node | None:
    """Return the node tree of one YAML document, None if it is empty or cannot be read.

    start: place of the text; lines are counted only if it has one.
    path: key path of the document, for faults.
    """
    builder, line = _Builder(report, start), 0
    try:
        loader = _Loader(text)
        composed = loader.get_single_node()
        node = None if composed is None else builder.node(composed, path, 0)
        return None if isinstance(node, Scalar) and node.is_null else node
    except _Stop:
        return None
    except RecursionError:
        path, problem, line = path[:8], TOO_DEEP, loader.line
    except yaml.reader.ReaderError as error:
        line = text.count("\n", 0, error.position)
        problem = f"not valid YAML: the character {chr(int(error.character))!a} is not allowed"
    except yaml.MarkedYAMLError as error:
        mark = error.problem_mark or error.context_mark
        problem, line = f"not valid YAML: {_in_words(error, text)}", mark.line if mark else 0
    except (yaml.YAMLError, ValueError, OverflowError) as error:  # such as an escape beyond Unicode
        problem, line = f"not valid YAML: {clean(str(error))}", loader.line
    report.fault(path, problem, builder.at(line))
    return None


def _in_words(error: yaml.MarkedYAMLError, text: str) -> str:
    """What the parser says, in whole, and for what goes wrong most often what to do."""
    problem, context = error.problem or "unreadable", f"{error.context}, " if error.context else ""
    told = "".join(letter if letter.isprintable() else ascii(letter)[1:-1] for letter in context + problem)
    mark = error.problem_mark
    lines = text.splitlines()
    line = lines[mark.line] if mark is not None and mark.line < len(lines) else ""
    opened = error.context_mark.line + 1 if error.context_mark is not None else 0
    if "'\\t'" in problem or "\t" in line[: len(line) - len(line.lstrip())]:
        return f"{told}: indent with spaces, not with a tab"
    if problem.startswith("mapping values are not allowed"):
        return f"{told}: a text with ': ' in it stands in quotes, and keys of one mapping stand in one column"
    if problem.startswith("but found another document"):
        return f"{told}: a case file holds one"
    if (error.context or "").startswith("while parsing a flow"):
        return f"{told}: a bracket or brace that opens in line {opened} is not closed, or a comma is missing"
    if (error.context or "").startswith("while parsing a block"):
        return f"{told}: keys of one mapping, or items of one list, which begins in line {opened}, stand in one column"
    return told


def has_half_pair(text: str) -> bool:
    """Whether a text holds half of a surrogate pair, and so can't be written into files."""
    return any("\ud800" <= letter <= "\udfff" for letter in text)


class _Loader(yaml.SafeLoader):
    """Leaves plain scalars without a tag: whether 5 is a number, the key that takes it decides."""

    def resolve(self, kind: type[yaml.Node], value: Any, implicit: Any) -> str:
        if kind is yaml.ScalarNode and implicit[0]:
            return NO_TAG
        return str(super().resolve(kind, value, implicit))  # type: ignore[no-untyped-call]

    def compose_node(self, parent: yaml.Node | None, index: Any) -> Any:
        """Compose a node. An alias without an anchor is one with a tag of its own; an anchor may be given anew."""
        event: Any = self.peek_event()  # type: ignore[no-untyped-call]
        if isinstance(event, yaml.AliasEvent) and event.anchor not in self.anchors:
            self.get_event()  # type: ignore[no-untyped-call]
            begin: Any = event.start_mark
            return yaml.ScalarNode(UNKNOWN, event.anchor or "", begin)
        if isinstance(event, yaml.NodeEvent) and not isinstance(event, yaml.AliasEvent) and event.anchor:
            self.anchors.pop(event.anchor, None)
        return super().compose_node(parent, index)


class _Builder:
    """Makes nodes of those that PyYAML composes; each alias gets a value of its own, as an override may change it."""

    def __init__(self, report: Report, start: Place) -> None:
        self.report = report
        self.start = start
        self.seen: set[int] = set()
        self.copies = 0

    def at(self, line: int) -> Place:
        """The place of a line, counted from 0."""
        return self.start if self.start.line is None else Place(self.start.source, line + 1)

    def stop(self, reason: str, path: Path, place: Place) -> NoReturn:
        self.report.fault(path[:8], reason, place)
        raise _Stop

    def node(self, given: yaml.Node, path: Path, depth: int) -> Node:
        place = self.at(given.start_mark.line)
        self.copies += id(given) in self.seen
        self.seen.add(id(given))
        if depth > MAX_DEPTH:
            self.stop(TOO_DEEP, path, place)
        if self.copies > MAX_COPIES:
            self.stop(f"aliases stand for more than {MAX_COPIES:,} values", path, place)
        if isinstance(given, yaml.ScalarNode):
            return self.scalar(given, path, place)
        if given.tag != _CORE + ("map" if isinstance(given, yaml.MappingNode) else "seq"):
            return self.refused_tag(given.tag, path, place)
        if isinstance(given, yaml.MappingNode):
            return self.table(given, path, place, depth)
        return Listing([self.node(its, (*path, k), depth + 1) for k, its in enumerate(given.value)], place)

    def scalar(self, given: yaml.ScalarNode, path: Path, place: Place) -> Node:
        if given.tag == UNKNOWN:
            name = clean(given.value)
            self.report.fault(path, f"alias *{name}: no value before it has the anchor &{name}", place)
            return Broken(place)
        plain = given.tag != _CORE + "str"
        if plain and given.tag.removeprefix(_CORE) not in _SCALAR_TAGS:
            return self.refused_tag(given.tag, path, place)
        if has_half_pair(given.value):
            self.report.fault(path, f"{quoted(given.value)} holds half of a surrogate pair, which is no text", place)
            return Broken(place)
        return Scalar(given.value, plain, place)

    def refused_tag(self, tag: str, path: Path, place: Place) -> Broken:
        self.report.fault(path, f"the tag {quoted(tag)} is not allowed; write the plain value", place)
        return Broken(place)

    def table(self, given: yaml.MappingNode, path: Path, place: Place, depth: int) -> Table:
        entries: dict[str, Entry] = {}
        for its_key, its_value in given.value:
            key = self.node(its_key, path, depth + 1)
            inner = (*path, key.text) if isinstance(key, Scalar) else path
            value = self.node(its_value, inner, depth + 1)
            if not isinstance(key, Scalar):
                if not isinstance(key, Broken):
                    self.report.fault(path, "a key must be a single word, not a list or mapping", key.place)
            elif key.plain and key.text == "<<":
                self.report.fault(inner, "merge keys are not allowed, write the keys out", key.place)
            elif key.text in entries:
                first = entries[key.text].place.line
                where = "" if first is None else f"; the first is in line {first}"
                self.report.fault(inner, f"this key is given twice{where}", key.place)
            else:
                entries[key.text] = Entry(key.place, value)
        return Table(entries, place)
