"""Ragged lists."""

from __future__ import annotations

import numpy as np

from crackgrow.ragged import Ragged, by_row, numbered, spans, starts_of

LISTS = [np.array([5, 7]), np.array([], dtype=np.int64), np.array([1, 2, 3]), np.array([9])]


def listed(lists: list[np.ndarray]) -> Ragged:
    return Ragged(starts_of(np.array([len(some) for some in lists])), np.concatenate(lists))


def test_lists_come_out_as_they_went_in() -> None:
    ragged = listed(LISTS)
    assert ragged.n == 4
    assert [ragged.of(row).tolist() for row in range(4)] == [some.tolist() for some in LISTS]
    np.testing.assert_array_equal(ragged.counts, [2, 0, 3, 1])
    np.testing.assert_array_equal(ragged.row, [0, 0, 2, 2, 2, 3])
    again = by_row(ragged.row, ragged.values, 4)
    np.testing.assert_array_equal(again.start, ragged.start)


def test_rows_are_taken_in_any_order_and_again() -> None:
    ragged = listed(LISTS)
    rows = np.array([2, 1, 0, 2])
    which, place = ragged.places(rows)
    np.testing.assert_array_equal(which, [0, 0, 0, 2, 2, 3, 3, 3])
    np.testing.assert_array_equal(place, [2, 3, 4, 0, 1, 2, 3, 4])
    taken = ragged.taken(rows)
    np.testing.assert_array_equal(taken.values, ragged.values[place])
    np.testing.assert_array_equal(taken.row, which)


def test_some_values_alone_are_kept() -> None:
    kept = listed(LISTS).kept(np.array([True, False, False, True, True, False]))
    assert [kept.of(row).tolist() for row in range(4)] == [[5], [], [2, 3], []]


def test_spans_follow_each_other() -> None:
    np.testing.assert_array_equal(spans(np.array([4, 0, 8]), np.array([2, 0, 3])), [4, 5, 8, 9, 10])
    np.testing.assert_array_equal(starts_of(np.array([2, 0, 3])), [0, 2, 2, 5])


def test_values_are_numbered_as_by_sorting() -> None:
    values = np.array([7, 2, 9, 2, 7])
    found, place = numbered(values, 12)
    np.testing.assert_array_equal(found, [2, 7, 9])
    np.testing.assert_array_equal(found[place], values)
    assert [len(part) for part in numbered(values[:0], 12)] == [0, 0]
