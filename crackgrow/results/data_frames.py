"""The CSV tables as pandas DataFrames: the same columns, rows and values, in SI units."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import numpy as np
import pandas as pd

from crackgrow.results import tables
from crackgrow.results.folder import TextTable
from crackgrow.run.result import CrackPath, Event, StepResult

COUNTS = frozenset({"step", "vertex", "increment", "n_dofs", "n_contact", "contact_iterations", "factorizations"})
WORDS = frozenset({"crack", "tip", "criterion", "K_note", "state", "kind", "met", "where", "contact_status"})
TRUTHS = frozenset({"advanced"})
"""Columns of whole numbers, of words, of true and false; all others are of numbers."""


def tips_frame(results: Iterable[StepResult]) -> pd.DataFrame:
    """Rows of tips.csv: one for each step and tip."""
    return _frame(tables.TIPS, [row for result in results for row in tables.tip_rows(result)])


def contact_frame(results: Iterable[StepResult]) -> pd.DataFrame:
    """Rows of contact.csv: one for each step and contact point."""
    return _frame(tables.CONTACT, [row for result in results for row in tables.contact_rows(result)])


def reactions_frame(results: Iterable[StepResult]) -> pd.DataFrame:
    """Rows of reactions.csv: one for each step and support, foundation or interface."""
    return _frame(tables.REACTIONS, [row for result in results for row in tables.reaction_rows(result)])


def history_frame(results: Sequence[StepResult]) -> pd.DataFrame:
    """Rows of history.csv: one for each increment; empty where the case names no points."""
    columns = next((tables.history_columns(result.history) for result in results if result.history), ())
    return _frame(columns, [row for result in results for row in tables.history_rows(result)])


def steps_frame(results: Iterable[StepResult]) -> pd.DataFrame:
    """Rows of steps.csv: one for each step; `seconds_output` is without the writing of frames."""
    return _frame(tables.STEPS, [tables.step_row(result, seconds_frames=0.0) for result in results])


def paths_frame(cracks: Iterable[CrackPath]) -> pd.DataFrame:
    """Rows of paths.csv: one for each vertex of each crack."""
    return _frame(tables.PATHS, tables.path_rows(cracks))


def events_frame(events: Iterable[Event]) -> pd.DataFrame:
    """Rows of events.csv: one for each tip that has met something."""
    return _frame(tables.EVENTS, tables.event_rows(events))


def frame_of(table: TextTable) -> pd.DataFrame:
    """A table of a run's folder, with the types that the same table has in memory."""
    columns: dict[str, object] = {}
    for name, words in table.columns.items():
        if name in WORDS:
            columns[name] = words
        elif name in TRUTHS:
            columns[name] = [word == "true" for word in words]
        else:
            numbers = table.numbers(name)
            columns[name] = numbers.astype(np.int64) if name in COUNTS else numbers
    return pd.DataFrame(columns)


def _frame(columns: Sequence[str], rows: Sequence[Sequence[tables.Value]]) -> pd.DataFrame:
    return pd.DataFrame([list(row) for row in rows], columns=pd.Index(columns))
