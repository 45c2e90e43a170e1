"""YAML text -> a tree of nodes that know their line. Nothing is constructed: a scalar stays text."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path as FilePath

import yaml

from crackgrow.case.report import Path, Place, Report, clean, quoted

MAX_DEPTH = 40  # of nested lists and mappings; the format needs 7
MAX_BYTES = 2**19  # its text takes two or three seconds to read
MAX_COPIES = 100_000  # of values that stand for aliases

_CORE = "tag:yaml.org,2002:"
_SCALAR_TAGS = {"str", "int", "float", "bool", "null"}


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
    path = FilePath(file)
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
            return _decode_and_parse(path.read_bytes(), report)
    except (OSError, ValueError) as error:  # ValueError: a null character in the name
        problem = f"cannot be read: {getattr(error, 'strerror', None) or error}"
    report.fault((), problem, Place(report.source, None))
    return None


def _decode_and_parse(data: bytes, report: Report) -> Node | None:
    try:
        text = data.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        line = data.count(b"\n", 0, error.start) + 1
        report.fault((), "is not a text in UTF-8", Place(report.source, line))
        return None
    node = parse(text, report, Place(report.source, 1))
    if node is None and not report.faults:
        report.fault((), "the file is empty")
    return node


def parse(text: str, report: Report, start: Place, path: Path = ()) -> Node | None:
    """Return the node tree of one YAML document, None if it is empty or cannot be read.

    start: place of the text; lines are counted only if it has one.
    path: key path of the document, for faults.
    """
    builder = _Builder(report, start, text)
    try:
        return builder.document(path)
    except _Stop:
        return None
    except yaml.reader.ReaderError as error:
        line = text.count("\n", 0, error.position) + 1
        letter = ascii(chr(int(error.character)))
        report.fault(path, f"not valid YAML: the character {letter} is not allowed", builder.at(line))
    except yaml.MarkedYAMLError as error:
        mark = error.problem_mark or error.context_mark
        report.fault(path, f"not valid YAML: {_in_words(error, text)}", builder.at(mark.line + 1 if mark else 1))
    except (yaml.YAMLError, ValueError, OverflowError) as error:  # such as an escape beyond Unicode
        report.fault(path, f"not valid YAML: {clean(str(error))}", builder.at(builder.line))
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
    if (error.context or "").startswith("while parsing a flow"):
        return f"{told}: a bracket or brace that opens in line {opened} is not closed, or a comma is missing"
    if (error.context or "").startswith("while parsing a block"):
        return f"{told}: keys of one mapping, or items of one list, which begins in line {opened}, stand in one column"
    return told


def has_half_pair(text: str) -> bool:
    """Whether a text holds half of a surrogate pair, and so can't be written into files."""
    return any("\ud800" <= letter <= "\udfff" for letter in text)


class _Builder:
    """Builds nodes from parser events: the depth is checked before anything recurses."""

    def __init__(self, report: Report, start: Place, text: str) -> None:
        self.report = report
        self.start = start
        self.line = 1
        self.anchors: dict[str, Node] = {}  # values that aliases may stand for, once they are whole
        self.copies = 0
        self.events: Iterator[yaml.Event] = yaml.parse(text, Loader=yaml.SafeLoader)

    def at(self, line: int) -> Place:
        return self.start if self.start.line is None else Place(self.start.source, line)

    def next(self) -> yaml.Event:
        event = next(self.events)
        self.line = event.start_mark.line + 1 if event.start_mark else self.line
        return event

    def document(self, path: Path) -> Node | None:
        self.next()  # start of the stream
        if isinstance(self.next(), yaml.StreamEndEvent):
            return None
        node = self.node(self.next(), path, 0)
        self.next()  # end of the document
        if not isinstance(self.next(), yaml.StreamEndEvent):
            self.report.fault(path, "a second YAML document starts here; a case file holds one", self.at(self.line))
        return None if isinstance(node, Scalar) and node.is_null else node

    def node(self, event: yaml.Event, path: Path, depth: int) -> Node:
        place = self.at(self.line)  # that of the event, the last one taken
        if depth > MAX_DEPTH:
            self.report.fault(path[:8], f"nested deeper than {MAX_DEPTH} levels", place)
            raise _Stop
        if isinstance(event, yaml.AliasEvent):
            return self.alias(event.anchor or "", path, place, depth)
        if isinstance(event, yaml.ScalarEvent):
            node = self.scalar(event, path, place)
        elif isinstance(event, yaml.SequenceStartEvent):
            node = self.checked_tag(event, "seq", path, self.listing(path, place, depth))
        else:
            node = self.checked_tag(event, "map", path, self.table(path, place, depth))
        if anchor := getattr(event, "anchor", None):
            self.anchors[anchor] = node
        return node

    def alias(self, anchor: str, path: Path, place: Place, depth: int) -> Node:
        """A value like that at the anchor; each alias has one of its own, as an override may change it."""
        if anchor in self.anchors:
            return self.copied(self.anchors[anchor], path, place, depth)
        self.report.fault(path, f"alias *{clean(anchor)}: no value before it has the anchor &{clean(anchor)}", place)
        return Broken(place)

    def copied(self, node: Node, path: Path, place: Place, depth: int) -> Node:
        self.copies += 1
        if self.copies > MAX_COPIES or depth > MAX_DEPTH:
            limit = f"{MAX_COPIES:,} values" if depth <= MAX_DEPTH else f"{MAX_DEPTH} levels"
            self.report.fault(path[:8], f"aliases stand for more than {limit}", place)
            raise _Stop
        if isinstance(node, Listing):
            return Listing([self.copied(item, path, place, depth + 1) for item in node.items], node.place)
        if isinstance(node, Table):
            entries = {
                key: Entry(entry.place, self.copied(entry.node, path, place, depth + 1))
                for key, entry in node.entries.items()
            }
            return Table(entries, node.place)
        return replace(node)

    def scalar(self, event: yaml.ScalarEvent, path: Path, place: Place) -> Node:
        plain = event.style is None
        if event.tag == "!" or event.tag == _CORE + "str":
            plain = False
        elif event.tag is not None and event.tag.removeprefix(_CORE) in _SCALAR_TAGS:
            plain = True
        elif event.tag is not None:
            return self.refused_tag(event.tag, path, place)
        if has_half_pair(event.value):
            self.report.fault(path, f"{quoted(event.value)} holds half of a surrogate pair, which is no text", place)
            return Broken(place)
        return Scalar(event.value, plain, place)

    def checked_tag(self, event: yaml.Event, name: str, path: Path, node: Listing | Table) -> Node:
        tag = event.tag  # type: ignore[attr-defined]  # both collection events have one
        return node if tag in (None, "!", _CORE + name) else self.refused_tag(tag, path, node.place)

    def refused_tag(self, tag: str, path: Path, place: Place) -> Broken:
        self.report.fault(path, f"the tag {quoted(tag)} is not allowed; write the plain value", place)
        return Broken(place)

    def listing(self, path: Path, place: Place, depth: int) -> Listing:
        items: list[Node] = []
        while not isinstance(event := self.next(), yaml.SequenceEndEvent):
            items.append(self.node(event, (*path, len(items)), depth + 1))
        return Listing(items, place)

    def table(self, path: Path, place: Place, depth: int) -> Table:
        entries: dict[str, Entry] = {}
        while not isinstance(event := self.next(), yaml.MappingEndEvent):
            key = self.node(event, path, depth + 1)
            inner = (*path, key.text) if isinstance(key, Scalar) else path
            value = self.node(self.next(), inner, depth + 1)
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
