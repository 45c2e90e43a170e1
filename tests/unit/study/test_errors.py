"""Distances of polylines, errors against a reference, order and limit: against what is known, and sampled ones."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
import shapely

from crackgrow.arrays import Floats
from crackgrow.geometry.polyline import arc_lengths
from crackgrow.study.distance import RESOLUTION, WALKED, extent, farthest, frechet, nearest
from crackgrow.study.errors import K_errors, contact_errors, errors_of
from crackgrow.study.findings import LEAST_ORDER, limit_of

SAMPLE = 0.05  # between the samples of the discrete Frechet distance, which is at most this much larger


def line(*points: tuple[float, float]) -> Floats:
    return np.array(points, dtype=float)


def random_lines(seed: int) -> tuple[Floats, Floats]:
    rng = np.random.default_rng(seed)
    a = np.cumsum(rng.normal(size=(rng.integers(2, 10), 2)), axis=0)
    if seed % 2:
        return a, a + 0.1 * rng.normal(size=a.shape)
    return a, np.cumsum(rng.normal(size=(rng.integers(2, 10), 2)), axis=0)


POINT, ABOVE = line((0, 0)), line((0, 1), (0, 4))


def test_frechet_sees_the_order() -> None:
    """A line that runs back on itself is near everywhere, but not in the order of a walk: half of the way back."""
    there = line((0, 0), (10, 0))
    back = line((0, 0), (7, 0), (3, 0), (10, 0))
    assert max(farthest(there, back)[0], farthest(back, there)[0]) == 0.0
    assert frechet(there, back) == pytest.approx(2.0, abs=10 / WALKED)
    assert frechet(there, there[::-1]) == pytest.approx(10.0)
    assert frechet(POINT, ABOVE) == 4.0


@pytest.mark.parametrize("seed", range(12))
def test_distances_against_sampled_ones(seed: int) -> None:
    a, b = random_lines(seed)
    fine = RESOLUTION * extent(a, b) * 2
    lines = [shapely.segmentize(shapely.LineString(points), SAMPLE) for points in (a, b)]
    samples_a, samples_b = map(shapely.get_coordinates, lines)
    hausdorff = max(farthest(a, b)[0], farthest(b, a)[0])
    sampled = max(nearest(samples_a, b)[0].max(), nearest(samples_b, a)[0].max())
    assert sampled - fine <= hausdorff <= sampled + SAMPLE / 2
    leash = frechet(a, b)
    step = max(arc_lengths(a)[-1], arc_lengths(b)[-1]) / WALKED
    assert leash - step <= shapely.frechet_distance(*lines) <= leash + SAMPLE
    assert leash >= hausdorff - fine
    assert frechet(b, a) == pytest.approx(leash, rel=1e-12)


def table(columns: str, *rows: tuple[str | float, ...]) -> pd.DataFrame:
    return pd.DataFrame([list(row) for row in rows], columns=pd.Index(columns.split()))


def tips(*K: tuple[float, float]) -> pd.DataFrame:
    return table("crack tip K_I K_II", *((f"c{i}", "end", *both) for i, both in enumerate(K)))


def contact(s: np.ndarray, scale: float = 1.0, shift: float = 0.0) -> pd.DataFrame:
    """A pressure of 3, a shear of 4 and an elliptic slip, on a face of length 2; `shift` is added to the pressure."""
    slip = scale * np.sqrt(np.maximum(s * (2 - s), 0.0))
    rows = [("flaw", x, -3.0 + shift, 4.0, y) for x, y in zip(s.tolist(), slip.tolist(), strict=True)]
    return table("crack s normal_traction tangential_traction slip", *rows)


def test_K_errors_are_relative_to_the_largest_K_and_unknown_without_a_size():
    assert K_errors(tips((0.3, 5.4), (0.0, 2.0)), tips((0.0, 5.0), (0.0, 2.0))) == pytest.approx((0.1, 0.08))
    assert K_errors(tips((2.2, 1e-4)), tips((2.0, 2e-4))) == pytest.approx((0.1, math.nan), rel=1e-6, nan_ok=True)
    assert all(map(math.isnan, K_errors(tips(), tips((1.0, 1.0)))))


def test_contact_errors_do_not_depend_on_where_the_points_lie():
    fine, coarse = contact(np.linspace(0.02, 1.98, 197)), contact(np.linspace(0.3, 1.7, 5), scale=1.1, shift=0.1)
    pressure, shear, slip = contact_errors(coarse, fine)
    assert pressure == pytest.approx(0.1 / 5.0, rel=1e-12)  # of hypot(3, 4)
    assert shear == 0.0
    assert slip == pytest.approx(0.1, rel=1e-4)  # the interpolation between points 0.01 apart is better than that


@pytest.mark.parametrize("rounding", [0.0, 1e-14])
def test_each_side_of_a_kink_is_held_against_its_own(rounding: float) -> None:
    """Two contact points lie at a kink, one for each side, and the pressure jumps there, from 3 to 5."""

    def kinked(before: int, after: int, off: float = 0.0) -> pd.DataFrame:
        places = [np.linspace(1.0, 0.1, before)[::-1], np.linspace(1.0 + off, 1.9, after)]
        rows = [("flaw", x, -p, 0.0, p) for p, s in zip((3.0, 5.0), places, strict=True) for x in s.tolist()]
        return table("crack s normal_traction tangential_traction slip", *rows)

    pressure, _, slip = contact_errors(kinked(4, 3, rounding), kinked(9, 8))
    assert (pressure, slip) == (0.0, 0.0)
    assert contact_errors(kinked(4, 1, rounding), kinked(1, 8)) == (0.0, 0.0, 0.0)


def results(folder: Path, end: tuple[float, float], *, steps: int = 2) -> Path:
    """A folder with a crack along x from 0 to 1 that has grown from its end to `end`."""
    folder.mkdir()
    (folder / "case.yaml").write_text("title: a crack\n")
    (folder / "tips.csv").write_text("step,crack,tip,K_I,K_II\n0,a,end,1.0,2.0\n1,a,end,9.0,9.0\n")
    (folder / "contact.csv").write_text("step,crack,s,normal_traction,tangential_traction,slip\n")
    (folder / "steps.csv").write_text("step,strain_energy\n0,4.0\n1,7.0\n")
    grown = f"a,2,{end[0]},{end[1]},{steps}\n"
    (folder / "paths.csv").write_text(f"crack,vertex,x,y,step\na,0,0.0,0.0,0\na,1,1.0,0.0,0\n{grown}")
    return folder


def test_paths_are_compared_as_far_as_both_have_grown(tmp_path: Path):
    long, short = results(tmp_path / "long", (3.0, 0.0)), results(tmp_path / "short", (2.0, 0.01))
    errors = errors_of(short, long, grows=True)
    assert errors["path_hausdorff"] == pytest.approx(0.01, rel=1e-4)
    assert errors["length_error"] == pytest.approx(1.0, rel=1e-4)
    assert (errors["K_error"], errors["energy_error"]) == (0.0, 0.0)
    assert math.isnan(errors["pressure_error"])


@pytest.mark.parametrize("order", [0.6, 1.0, 1.5, 2.0])
@pytest.mark.parametrize("sizes", [(4.0, 2.0, 1.0), (3.0, 1.7, 1.2), (1e-3, 5e-4, 1e-4)])
@pytest.mark.parametrize("factor", [-0.3, 2.0])
def test_a_power_law_gives_its_order_and_its_limit(order: float, sizes: tuple[float, ...], factor: float) -> None:
    values = [5.0 + factor * (size / sizes[0]) ** order for size in sizes]
    limit = limit_of(values, sizes)
    assert limit.order == pytest.approx(order, rel=1e-6)
    assert limit.value == pytest.approx(5.0, abs=1e-6)
    assert limit.rest == pytest.approx(abs(values[-1] - 5.0), abs=1e-6)


@pytest.mark.parametrize(("values", "order", "rest"), [
    ([1.0, 1.4, 1.3], math.nan, 0.2),  # to and fro: half of what they vary
    ([1.0, 1.1, 1.5], math.nan, 0.4),  # changes that grow are no convergence
    ([2.0, 1.001, 1.0], 9.964, 0.001 / 3.0),  # an order that is an accident does not make the finest exact: as with 2
    # slow convergence is not extrapolated without bound
    ([1.0 + 0.1 * size**0.1 for size in (4.0, 2.0, 1.0)], 0.1, 0.1 * (2.0**0.1 - 1.0) / (2.0**LEAST_ORDER - 1.0)),
    ([1.0, 1.0, 1.0], math.nan, 0.0),
])  # fmt: skip
def test_values_without_a_usual_order_are_off_by_a_bound(values: list[float], order: float, rest: float) -> None:
    limit = limit_of(values, (4.0, 2.0, 1.0))
    assert limit.order == pytest.approx(order, rel=1e-3, nan_ok=True)
    assert limit.rest == pytest.approx(rest, rel=1e-9)
    assert limit.value == values[-1] or math.isfinite(order)
