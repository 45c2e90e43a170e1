"""What is to be known of keys, files and columns: made of their declarations, for `explain` and the READMEs."""

from __future__ import annotations

import difflib
import re
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import pairwise
from textwrap import TextWrapper
from typing import Final

from crackgrow.case.keys import NAME, NUMBER, Key, case_keys
from crackgrow.results.declarations import RUN, Column, File, columns_of, declared

FOLDERS: Final = {"run": RUN} | {command: declared(files) for command, files in columns_of("study").items()}
"""Files by the command that writes them."""


@dataclass(frozen=True, slots=True)
class Entry:
    """A key, a file or a column."""

    name: str
    facts: dict[str, str]  # label to words; those that are empty are left out

    def lines(self, width: int, most: int | None = None) -> list[str]:
        """The entry for a terminal of a width: its name, below it the facts, wrapped, in `most` lines each."""
        indent = max(map(len, self.facts), default=0) + 4
        filled = TextWrapper(max(width, indent + 20), break_long_words=False, break_on_hyphens=False, max_lines=most)
        filled.placeholder = " ..."
        filled.subsequent_indent = " " * indent
        found = [self.name]
        for label, words in self.facts.items():
            filled.initial_indent = f"  {label}".ljust(indent)
            found += filled.wrap(words)
        return found


def key_entry(key: Key) -> Entry:
    """What is to be known of a key of a case."""
    facts = {
        "meaning": key.doc,
        "type": key.kind + (f", with the keys of {key.like}" if key.like else ""),
        "unit": key.units,
        "default": key.default,
        "allowed": key.allowed,
    }
    return Entry(key.name, {label: words for label, words in facts.items() if words})


def column_entry(file: File, column: Column) -> Entry:
    """What is to be known of a column, a field of a frame, or a key of a JSON file."""
    facts = {"meaning": column.doc, "unit": column.unit, "in": file.name}
    return Entry(column.name, {label: words for label, words in facts.items() if words})


def file_entry(file: File, command: str) -> Entry:
    """What is to be known of a file."""
    return Entry(file.name, {"meaning": file.doc, "written by": f"crackgrow {command}"})


def first_entries() -> list[Entry]:
    """The keys that a case begins with, and the files of a run: a fact each."""
    keys = {key.name: key.doc for key in case_keys() if "." not in key.name}
    return [Entry("keys of a case", keys), Entry("files of a run", {file.name: file.doc for file in RUN})]


def explain(name: str) -> list[Entry]:
    """What there is of a name: a key with those below it, a file with its columns, or a column of any file.

    A key may be given with the user's own names and numbers, or by its last part alone.
    """
    keys = case_keys()
    exact = [key for key in keys if _is(key.name, name)]
    if exact:
        return [key_entry(key) for key in keys if key in exact or _is_below(key.name, name)]
    whole = [(command, file) for command, file in _files() if file.name == name]
    if whole:
        return [
            entry
            for command, file in whole
            for entry in (file_entry(file, command), *(column_entry(file, column) for column in file.columns))
        ]
    tails = [key for key in keys if key.name.endswith(f".{name}")]
    first = [key for key in tails if not any(_repeats(key, other) for other in tails)]
    columns = [column_entry(file, column) for _, file in _files() for column in file.columns if column.name == name]
    return [*(key_entry(key) for key in first), *columns] or list(_word_entries(name))


def _word_entries(name: str) -> Iterator[Entry]:
    """The keys that take a word, such as `critical`, or the one of them that is named before it: loading.critical."""
    before, _, word = name.rpartition(".")
    for key in case_keys():
        told = re.search(rf"`{re.escape(word)}`(?:: (.*?))?(?=; `|, or |$)", key.allowed)
        if told and not _below_a_like(key.name) and (not before or _is(key.name, before)):
            facts = {"meaning": told[1] or "", "key": f"{key.name}: {key.doc}", "default": key.default}
            yield Entry(f"{key.name}: {word}", {label: words for label, words in facts.items() if words})


def nearest(name: str) -> list[str]:
    """Names that are like one that there is not, the nearest first."""
    keys = [key.name for key in case_keys()]
    names = [*keys, *(key.rpartition(".")[2] for key in keys)]
    names += [name for _, file in _files() for name in (file.name, *file.header)]
    return difflib.get_close_matches(name, list(dict.fromkeys(names)), n=3)


def sections() -> Iterator[tuple[str, list[Key]]]:
    """The keys by the one that they begin with; those below a mapping that has been told before are left out."""
    keys = [key for key in case_keys() if not _below_a_like(key.name)]
    starts = [place for place, key in enumerate(keys) if "." not in key.name]
    for begin, end in pairwise([*starts, len(keys)]):
        yield keys[begin].name, keys[begin:end]


def _below_a_like(name: str) -> bool:
    return any(key.like and name.startswith(f"{key.name}.") for key in case_keys())


def _repeats(key: Key, other: Key) -> bool:
    """Whether a key is another one again, below a mapping that both have."""
    holders = [holder for holder in case_keys() if holder.like and key.name.startswith(f"{holder.name}.")]
    return any(other.name == holder.like + key.name.removeprefix(holder.name) for holder in holders)


def _is(pattern: str, name: str) -> bool:
    """Whether a name is that of a key, with any words for NAME and N."""
    parts, given = pattern.split("."), name.split(".")
    return len(parts) == len(given) and all(a in (NAME, NUMBER) or a == b for a, b in zip(parts, given, strict=True))


def _is_below(pattern: str, name: str) -> bool:
    given = name.count(".") + 1
    return _is(".".join(pattern.split(".")[:given]), name)


def _files() -> Iterator[tuple[str, File]]:
    for command, files in FOLDERS.items():
        yield from ((command, file) for file in files)
