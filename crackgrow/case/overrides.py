"""Keys set over those of a file: by the command line, "numerics.spacing=1.5", or by a file with `base` and `set`."""

from __future__ import annotations

import re
from dataclasses import dataclass
from pathlib import Path as FilePath
from typing import Final

from crackgrow.case.reader import MAX_DEPTH, Broken, Entry, Listing, Node, Scalar, Table, parse, read_file
from crackgrow.case.report import Path, Place, Report, clean, did_you_mean, quoted
from crackgrow.case.scalars import INVALID, Context, given

WORD_OR_MAPPING: Final = {("loading",): "", ("growth", "initiation"): "at"}
"""Keys that take a word or a mapping: with an override of a key inside, the word stands for this key, or gives way."""

LONGEST_CHAIN: Final = 20  # files, each of which is the base of the one before it
BESIDE: Final = ("title", "source")  # keys that may stand beside `base`


def apply_override(root: Table, override: str, report: Report) -> None:
    """Set one "key.path=value" into the tree; what is wrong with it goes to the report."""
    key, equals, text = override.partition("=")
    key = key.strip()
    place = Place(f"--set {clean(key)}", None)
    if not equals:
        report.fault((), f"{quoted(override)} has no '='; an override is written key.path=value", place)
        return
    parts = key_parts(key, place, report)
    if parts is None:
        return
    n_faults = len(report.faults)
    value = parse(text, report, place, parts)
    if len(report.faults) == n_faults:
        set_value(root, parts, value or Scalar("", True, place), place, report)


def key_parts(key: str, place: Place, report: Report) -> tuple[str, ...] | None:
    """The parts of a dotted key, None after reporting why it is none."""
    parts = tuple(key.split("."))
    if not all(parts) or len(parts) > MAX_DEPTH:
        report.fault((), f"{quoted(key)} is not a key path such as numerics.spacing", place)
        return None
    if re.search(r"\[\d+\]", key):
        written = re.sub(r"\[(\d+)\]", r".\1", key)
        report.fault((), f"an item of a list is written with its number, as in {quoted(written)}", place)
        return None
    return parts


def set_value(root: Table, parts: tuple[str, ...], value: Node, place: Place, report: Report) -> None:
    """Put a value at a key of the tree, with the mappings on the way to it; a list has to hold the number."""
    node: Node = root
    parent = root
    for depth, part in enumerate(parts):
        last = depth == len(parts) - 1
        if isinstance(node, Scalar) and parts[:depth] in WORD_OR_MAPPING:
            key = WORD_OR_MAPPING[parts[:depth]]
            node = Table({key: Entry(place, node)} if key else {}, place)
            parent.entries[parts[depth - 1]] = Entry(place, node)
        if isinstance(node, Table):
            parent = node
            if last:
                node.entries[part] = Entry(place, value)
            elif part not in node.entries:
                node.entries[part] = Entry(place, Table({}, place), implied=True)
            node = node.entries[part].node
        elif isinstance(node, Listing):
            if not re.fullmatch("[0-9]{1,9}", part) or int(part) >= len(node.items):
                here = f"a list of {len(node.items)}, counted from 0; {quoted(part)} is none of its numbers"
                report.fault(parts[: depth + 1], f"{'.'.join(parts[:depth])} is {here}", place)
                return
            if last:
                node.items[int(part)] = value
            node = node.items[int(part)]
        elif not isinstance(node, Broken):
            here = clean(".".join(parts[:depth]))
            report.fault(parts[: depth + 1], f"{here} is the single value {quoted(node.text)}: no key inside it", place)
            return


@dataclass(frozen=True, slots=True)
class OfFile:
    """A key by which a file takes from another one; what a case is made of holds it no more."""

    kind: str

    def describe(self) -> str:
        return self.kind

    def read(self, node: Node, path: Path, context: Context) -> object:
        """Refuse an override: the base has been read by then."""
        if not isinstance(node, Broken):
            context.report.fault(path, "stands in the case file and takes no override; write another file with a base")
        return INVALID


def with_base(
    root: Node | None, path: FilePath, report: Report, folders: dict[str, FilePath], above: tuple[FilePath, ...] = ()
) -> Table | None:
    """Return what a file says together with its base, None if that cannot be told; faults go to the report.

    folders: gets, by the name of each file in faults, what file names in it are relative to
    above: the files that this one is a base of
    """
    if not isinstance(root, Table):
        if root is not None and not isinstance(root, Broken):
            report.fault((), "the file holds no mapping; a case is written as key: value", root.place)
        return None
    folders[str(path)] = path.parent
    if "base" not in root.entries:
        if "set" in root.entries:
            report.fault(("set",), "there is no `base` whose keys it could set", root.entries["set"].place)
            del root.entries["set"]
        return root
    for key in [key for key in root.entries if key not in ("base", "set", *BESIDE)]:
        message = f"beside `base` stand {', '.join(BESIDE)} and `set`; what differs is written as set: {{{key}: ...}}"
        report.fault((key,), message, root.entries[key].place)
    file = _base_of(root.entries["base"].node, path, report, (*above, path))
    if file is None:
        return None
    base = with_base(read_file(file, report), file, report, folders, (*above, path))
    if base is not None:
        _change(base, root, report)
    return base


def _base_of(node: Node, path: FilePath, report: Report, files: tuple[FilePath, ...]) -> FilePath | None:
    """The file that a case is based on, None after reporting why there is none."""
    if not isinstance(node, Scalar) or not node.text.strip() or node.is_null or "\0" in node.text:
        report.fault(("base",), f"{given(node)} given; wanted: a case file, relative to this one", node.place)
        return None
    file = path.parent / node.text
    chain = [one.resolve() for one in files]
    try:
        there, found = file.resolve(), file.is_file()
    except OSError as error:  # no name of a file can be so long
        report.fault(("base",), f"{error.strerror}; wanted: a case file, relative to this one", node.place)
        return None
    if there in chain:
        names = " -> ".join(one.name for one in (*files[chain.index(there) :], file))
        report.fault(("base",), f"a case cannot be its own base: {names}", node.place)
    elif len(files) > LONGEST_CHAIN:
        report.fault(("base",), f"a base of a base, {len(files)} times; wanted: {LONGEST_CHAIN} at most", node.place)
    elif not found:
        near = did_you_mean(file.name, sorted(one.name for one in file.parent.glob("*.yaml")))
        report.fault(("base",), f"there is no case file {file}{near}", node.place)
    else:
        return file
    return None


def _change(base: Table, root: Table, report: Report) -> None:
    """Set into a base what a file says otherwise."""
    for key in BESIDE:
        if key in root.entries:
            base.entries[key] = root.entries[key]
    settings = root.entries.get("set")
    if settings is None:
        return
    if not isinstance(settings.node, Table):
        if not isinstance(settings.node, Broken):
            message = f"{given(settings.node)} given; wanted: keys as --set takes them, such as growth.steps: 3"
            report.fault(("set",), message, settings.place)
        return
    for key, entry in settings.node.entries.items():
        parts = key_parts(key, entry.place, report)
        if parts is not None:
            set_value(base, parts, entry.node, entry.place, report)
