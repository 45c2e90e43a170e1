"""Overrides from the command line: "numerics.spacing=1.5" set into the node tree before it is checked."""

from __future__ import annotations

import re
from typing import Final

from crackgrow.case.reader import MAX_DEPTH, Broken, Entry, Listing, Node, Scalar, Table, parse
from crackgrow.case.report import Place, Report, clean, quoted

WORD_OR_MAPPING: Final = {("loading",): "", ("growth", "initiation"): "at"}
"""Keys that take a word or a mapping: with an override of a key inside, the word stands for this key, or gives way."""


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
            node = _spelt_out(node, WORD_OR_MAPPING[parts[:depth]], place)
            parent.entries[parts[depth - 1]] = Entry(place, node)
        if isinstance(node, Table):
            parent = node
            if last:
                node.entries[part] = Entry(place, value)
            elif part not in node.entries:
                node.entries[part] = Entry(place, Table({}, place), implied=True)
            node = node.entries[part].node
        elif isinstance(node, Listing):
            index = _index(part, len(node.items))
            if index is None:
                here = f"a list of {len(node.items)}, counted from 0; {quoted(part)} is none of its numbers"
                report.fault(parts[: depth + 1], f"{'.'.join(parts[:depth])} is {here}", place)
                return
            if last:
                node.items[index] = value
            node = node.items[index]
        elif not isinstance(node, Broken):
            here = clean(".".join(parts[:depth]))
            report.fault(parts[: depth + 1], f"{here} is the single value {quoted(node.text)}: no key inside it", place)
            return


def _spelt_out(word: Scalar, key: str, place: Place) -> Table:
    """The mapping that a word stands for: of one key, or empty."""
    return Table({key: Entry(place, word)} if key else {}, place)


def _index(text: str, length: int) -> int | None:
    if not re.fullmatch("[0-9]{1,9}", text):
        return None
    return int(text) if int(text) < length else None
