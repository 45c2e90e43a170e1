"""What is to be known of keys, files and columns: made of their declarations, for `explain` and the READMEs."""

from __future__ import annotations

import difflib
import re
import shutil
from collections.abc import Iterator
from textwrap import TextWrapper
from typing import Final, NamedTuple

from crackgrow.case.keys import NAME, NUMBER, Key, case_keys
from crackgrow.errors import CaseError
from crackgrow.results.declarations import RUN, Column, File, columns_of, declared

FOLDERS: Final = {"run": RUN} | {command: declared(files) for command, files in columns_of("study").items()}
"""Files by the command that writes them."""


class Entry(NamedTuple):
    """A key, a file or a column."""

    name: str
    facts: dict[str, str]  # label to words; those that are empty are left out

    def lines(self, width: int, most: int | None = None) -> list[str]:
        """The entry for a terminal of a width: its name, below it the facts, wrapped, in `most` lines each."""
        facts = {label: words for label, words in self.facts.items() if words}
        indent = max(map(len, facts), default=0) + 4
        filled = TextWrapper(max(width, indent + 20), break_long_words=False, break_on_hyphens=False, max_lines=most)
        filled.placeholder = " ..."
        filled.subsequent_indent = " " * indent
        found = [self.name]
        for label, words in facts.items():
            filled.initial_indent = f"  {label}".ljust(indent)
            found += filled.wrap(words)
        return found


def key_entry(key: Key) -> Entry:
    """What is to be known of a key of a case."""
    kind = key.kind + (f", with the keys of {key.like}" if key.like else "")
    facts = {"meaning": key.doc, "type": kind, "unit": key.units, "default": key.default, "allowed": key.allowed}
    return Entry(key.name, facts)


def _column_entry(file: File, column: Column) -> Entry:
    """What is to be known of a column, a field of a frame, or a key of a JSON file."""
    return Entry(column.name, {"meaning": column.doc, "unit": column.unit, "in": file.name})


def first_entries() -> list[Entry]:
    """The keys that a case begins with, and the files of a run: a fact each."""
    keys = {key.name: key.doc for key in case_keys() if "." not in key.name}
    return [Entry("keys of a case", keys), Entry("files of a run", {file.name: file.doc for file in RUN})]


def explained(name: str) -> str:
    """`crackgrow explain`: what is to be known of a key, a file or a column, in lines of the terminal's width.

    Raises CaseError for a name that there is not.
    """
    found = explain(name) if name else first_entries()
    if not found:
        near = nearest(name)
        hint = f"; did you mean {' or '.join(near)}?" if near else "; `crackgrow explain` lists what there is"
        raise CaseError.at("explain", f"is no key of a case, file or column of results{hint}", name)
    width = shutil.get_terminal_size().columns
    return "\n".join(line for entry in found for line in entry.lines(width, None if name else 1))


def explain(name: str) -> list[Entry]:
    """What there is of a name: a key with those below it, a file with its columns, or a column of any file.

    A key may be given with the user's own names and numbers, or by its last part alone.
    """
    keys = case_keys()
    exact = [key for key in keys if _is(key.name, name)]
    if exact:
        n = name.count(".") + 1
        return [key_entry(key) for key in keys if key in exact or _is(".".join(key.name.split(".")[:n]), name)]
    found = []
    for command, file in _files():
        if file.name == name:
            found.append(Entry(name, {"meaning": file.doc, "written by": f"crackgrow {command}"}))
            found += [_column_entry(file, column) for column in file.columns]
    if found:
        return found
    found = [key_entry(key) for key in keys if key.name.endswith(f".{name}") and not key.again]
    found += [_column_entry(file, column) for _, file in _files() for column in file.columns if column.name == name]
    return found or list(_word_entries(name))


def _word_entries(name: str) -> Iterator[Entry]:
    """The keys that take a word, such as `critical`, or the one of them that is named before it: loading.critical."""
    before, _, word = name.rpartition(".")
    for key in case_keys():
        told = re.search(rf"`{re.escape(word)}`(?:: (.*?))?(?=; `|, or |$)", key.allowed)
        if told and not key.again and (not before or _is(key.name, before)):
            facts = {"meaning": told[1] or "", "key": f"{key.name}: {key.doc}", "default": key.default}
            yield Entry(f"{key.name}: {word}", facts)


def nearest(name: str) -> list[str]:
    """Names that are like one that there is not, the nearest first."""
    keys = [key.name for key in case_keys()]
    names = [*keys, *(key.rpartition(".")[2] for key in keys)]
    names += [name for _, file in _files() for name in (file.name, *file.header)]
    return difflib.get_close_matches(name, list(dict.fromkeys(names)), n=3)


def _is(pattern: str, name: str) -> bool:
    """Whether a name is that of a key, with any words for NAME and N."""
    parts, given = pattern.split("."), name.split(".")
    return len(parts) == len(given) and all(a in (NAME, NUMBER) or a == b for a, b in zip(parts, given, strict=True))


def _files() -> Iterator[tuple[str, File]]:
    for command, files in FOLDERS.items():
        yield from ((command, file) for file in files)
