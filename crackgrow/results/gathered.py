"""The warnings of a run: one sentence a cause, with its places and steps, instead of one for each of them."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import asdict, dataclass
from typing import TYPE_CHECKING, Any

from crackgrow.results.units import cut, merged, spans_text

if TYPE_CHECKING:  # this module is on the command line's way to --version: no numpy
    from crackgrow.run.warning_causes import StepWarning

MOST_PLACES = 6  # that a sentence lists besides the worst
NUMBER = re.compile(r"[-+]?\d[\d.]*(e[-+]?\d+)?")


@dataclass(slots=True)
class _Told:
    """What has been told of one cause at one place."""

    cause: str
    rank: int  # of the cause: the smaller the more important
    place: str
    size: float
    words: str  # of the step where the size was largest
    worst: int  # that step
    steps: list[list[int]]  # first and last of each row of steps


class Gathered:
    """The warnings of a run, step after step."""

    def __init__(self) -> None:
        self._told: dict[tuple[str, str], _Told] = {}

    def add(self, step: int, warnings: Iterable[StepWarning]) -> list[str]:
        """Count in those of a step; returns a sentence for each cause that nothing has told of before at its places."""
        news: dict[str, list[_Told]] = {}
        for warning in warnings:
            name = warning.cause.lower()
            key = (_kind_of(name, warning.words), warning.place)
            if key not in self._told:
                row = _Told(name, warning.rank, warning.place, warning.size, warning.words, step, [[step, step]])
                self._told[key] = row
                news.setdefault(key[0], []).append(row)
                continue
            row = self._told[key]
            if step <= row.steps[-1][1] + 1:
                row.steps[-1][1] = step
            else:
                row.steps.append([step, step])
            if warning.size > row.size:
                row.size, row.words, row.worst = warning.size, warning.words, step
        return [_sentence(rows) for rows in news.values()]

    def sentences(self, *, with_steps: bool = True) -> list[str]:
        """One sentence a cause, the most important first: the worst place in words, the others by name."""
        by_kind: dict[str, list[_Told]] = {}
        for (kind, _), row in self._told.items():
            by_kind.setdefault(kind, []).append(row)
        causes = sorted(by_kind.values(), key=lambda rows: rows[0].rank)
        return [f"{_steps(rows) if with_steps else ''}{_sentence(rows)}" for rows in causes]

    def records(self) -> list[dict[str, Any]]:
        """One record for each cause and place, as mappings that JSON can hold."""
        rows = sorted(self._told.values(), key=lambda row: (row.rank, -row.size))
        return [asdict(row) for row in rows]

    @classmethod
    def of(cls, records: Sequence[Mapping[str, Any]]) -> Gathered:
        """What `records` tell of."""
        gathered = cls()
        for record in records:
            row = _Told(**record)
            gathered._told[(_kind_of(row.cause, row.words), row.place)] = row
        return gathered


def _kind_of(cause: str, words: str) -> str:
    """What is told in one sentence: a cause; of notes, those that differ in numbers alone."""
    return NUMBER.sub("#", words) if cause == "note" else cause


def _sentence(rows: Sequence[_Told]) -> str:
    """What is told of the worst place, and where else it is so."""
    worst, *others = sorted(rows, key=lambda row: -row.size)
    if not others:
        return worst.words
    return f"{worst.words}; likewise {', '.join(cut([row.place for row in others], MOST_PLACES, '{} more'))}"


def _steps(rows: Sequence[_Told]) -> str:
    """ "step 3: ", "steps 3 to 14, worst 7: ": when it was so at any of the places."""
    spans = merged(range(first, last + 1) for row in rows for first, last in row.steps)
    if len(spans) == len(spans[0]) == 1:
        return f"step {spans[0].start}: "
    most = max(rows, key=lambda row: row.size)
    worst = f", worst {most.worst}" if most.size else ""
    return f"steps {spans_text(spans)}{worst}: "
