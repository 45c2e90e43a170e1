"""Order and limit of values on three sizes of cells: laws whose order and limit are known."""

from __future__ import annotations

import math

import pytest

from crackgrow.study.extrapolation import LEAST_ORDER, limit_of, order_of


@pytest.mark.parametrize("order", [0.6, 1.0, 1.5, 2.0])
@pytest.mark.parametrize("sizes", [(4.0, 2.0, 1.0), (3.0, 1.7, 1.2), (1e-3, 5e-4, 1e-4)])
@pytest.mark.parametrize("factor", [-0.3, 2.0])
def test_a_power_law_gives_its_order_and_its_limit(order: float, sizes: tuple[float, ...], factor: float) -> None:
    values = [5.0 + factor * (size / sizes[0]) ** order for size in sizes]
    limit = limit_of(values, sizes)
    assert limit.order == pytest.approx(order, rel=1e-6)
    assert limit.value == pytest.approx(5.0, abs=1e-6)
    assert limit.rest == pytest.approx(abs(values[-1] - 5.0), abs=1e-6)


def test_values_that_go_to_and_fro_have_no_order_and_are_off_by_half_of_what_they_vary() -> None:
    limit = limit_of([1.0, 1.4, 1.3], (4.0, 2.0, 1.0))
    assert math.isnan(limit.order)
    assert (limit.value, limit.rest) == (1.3, pytest.approx(0.2))


def test_changes_that_grow_are_no_convergence() -> None:
    limit = limit_of([1.0, 1.1, 1.5], (4.0, 2.0, 1.0))
    assert math.isnan(limit.order)
    assert limit.rest == pytest.approx(0.4)


def test_an_order_that_is_an_accident_does_not_make_the_finest_exact() -> None:
    values = [2.0, 1.001, 1.0]  # order 10
    limit = limit_of(values, (4.0, 2.0, 1.0))
    assert limit.order > 9.0
    assert limit.rest == pytest.approx(0.001 / 3.0)  # as with order 2


def test_slow_convergence_is_not_extrapolated_without_bound() -> None:
    values = [1.0 + 0.1 * size**0.1 for size in (4.0, 2.0, 1.0)]
    limit = limit_of(values, (4.0, 2.0, 1.0))
    assert limit.order == pytest.approx(0.1, rel=1e-3)
    assert limit.rest == pytest.approx((values[1] - values[2]) / (2.0**LEAST_ORDER - 1.0))


def test_equal_cells_have_no_order() -> None:
    assert math.isnan(order_of([3.0, 2.0, 1.5], (2.0, 1.0, 1.0)))
    assert limit_of([1.0, 1.0, 1.0], (4.0, 2.0, 1.0)).rest == 0.0
