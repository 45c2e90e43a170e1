"""Comparing results: paths and distances that are known, errors against a reference, order and limit."""

from __future__ import annotations

import csv
import math
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest

from crackgrow import cli
from crackgrow.arrays import Floats
from crackgrow.study.compare import Comparison, compare_paths
from crackgrow.study.comparison_text import CSV_COLUMNS, comparison_csv, comparison_text
from crackgrow.study.distance import WALKED, farthest, frechet
from crackgrow.study.errors import K_errors, contact_errors, errors_of
from crackgrow.study.findings import LEAST_ORDER, limit_of

Vertex = tuple[float, float, int]  # mm, mm, step

# A flaw from (-5, 0) to (5, 0); its start has grown 4 mm to the left, its end 4 mm to the right, in turn.
STRAIGHT: list[Vertex] = [(-9, 0, 4), (-7, 0, 2), (-5, 0, 0), (5, 0, 0), (7, 0, 1), (9, 0, 3)]
LONGER: list[Vertex] = [*STRAIGHT, (11, 0, 5)]
# The end turns off by 0.3 mm; the largest distance, at its first vertex, is to a straight line.
BENT: list[Vertex] = [*STRAIGHT[:4], (7, 0.3, 1), (9, 0, 3)]


SHIFTED: list[Vertex] = [(-9, 0.1, 4), (-7, 0, 2), *STRAIGHT[2:]]
LIFTED: list[Vertex] = [(x, y + 0.5, step) for x, y, step in STRAIGHT]
FINE: list[Vertex] = [*STRAIGHT[:4], *((5 + 0.4 * i, 0.0, i) for i in range(1, 11))]
OFF: list[Vertex] = [*STRAIGHT[:4], (7, 0.3, 1), (9, 0.6, 3), (11, 0.9, 5)]


def folder(path: Path, settings: str | None = None, **cracks: list[Vertex]) -> Path:
    """A result folder with these cracks."""
    path.mkdir(exist_ok=True)
    rows = ["crack,vertex,x,y,step"]
    for name, vertices in cracks.items():
        rows += [f"{name},{i},{x * 1e-3!r},{y * 1e-3!r},{step}" for i, (x, y, step) in enumerate(vertices)]
    (path / "paths.csv").write_text("\n".join(rows) + "\n")
    if settings is not None:
        (path / "case.yaml").write_text(settings)
    return path


def compared(where: Path, a: list[Vertex], b: list[Vertex], **options: Any) -> Comparison:
    """Two paths of one flaw."""
    return compare_paths(folder(where / "a", flaw=a), folder(where / "b", flaw=b), **options)


def table(path: Path, text: str) -> Path:
    path.write_text(text)
    return path


@pytest.mark.parametrize(("a", "b", "apart", "ends"), [
    (BENT, BENT, (0, 0, 0), (0, 0, 0)),
    (STRAIGHT, FINE, (0, 0, 0), (0, 0, 0)),  # shorter steps along the same line
    (STRAIGHT, BENT, (0, 0, 0.3), (0, 0, 0)),
    (STRAIGHT, SHIFTED, (0, 0.1, 0), (0, 0.1, 0)),
    (STRAIGHT, LIFTED, (0.5, 0.5, 0.5), (0.5, 0.5, 0.5)),
    (STRAIGHT, LONGER, (0, 0, 2), (0, 0, 2)),
    (STRAIGHT, STRAIGHT[2:], (0, 4, 0), (0, 4, 0)),  # a tip that has grown in one only
])  # fmt: skip
def test_distances_of_the_given_crack_and_of_its_tips(
    a: list[Vertex], b: list[Vertex], apart: tuple[float, ...], ends: tuple[float, ...], tmp_path: Path
) -> None:
    """In mm, whichever is the first."""
    for one, other in ((a, b), (b, a)):
        result = compared(tmp_path, one, other, tolerance="0.4 mm")
        assert [pair.name for pair in result.pairs] == ["flaw given", "flaw start", "flaw end"]
        assert [1e3 * pair.deviation.hausdorff for pair in result.pairs] == pytest.approx(apart, rel=1e-3, abs=1e-5)
        assert [1e3 * pair.deviation.frechet for pair in result.pairs] == pytest.approx(apart, rel=1e-3, abs=1e-5)
        assert [1e3 * (pair.end_distance or 0.0) for pair in result.pairs] == pytest.approx(ends, abs=1e-9)
        beyond = [part for part, far in zip(("given", "start", "end"), apart, strict=True) if far > 0.4]
        assert [pair.part for pair in result.beyond] == beyond
        assert result.agrees == (not beyond)


def test_the_largest_distance_has_its_place_length_and_step_in_both(tmp_path: Path) -> None:
    end = compared(tmp_path, STRAIGHT, BENT).pairs[2]
    in_a, in_b = end.deviation.in_a, end.deviation.in_b
    assert in_b[:2] == pytest.approx([7e-3, 0.3e-3])
    assert in_a[:2] == pytest.approx([7e-3, 0.0], abs=1e-8)
    assert (in_a.s, in_b.s) == (pytest.approx(2e-3), pytest.approx((2**2 + 0.3**2) ** 0.5 * 1e-3))
    assert (in_a.step, in_b.step) == (1, 1)
    assert end.length_b - end.length_a == pytest.approx(2 * ((2**2 + 0.3**2) ** 0.5 - 2) * 1e-3)
    start = compared(tmp_path, STRAIGHT, SHIFTED).pairs[1]  # wings are measured from their root
    assert (start.deviation.in_b.step, start.deviation.in_a.s) == (4, pytest.approx(4e-3))


@pytest.mark.parametrize(("other", "size", "told"), [
    (LONGER, 0.0, "flaw end: B has grown 2.000 mm further; over the common part, 4.000 mm of A"),
    (LONGER, 0.0, ": the same path so far"),
    (OFF, 0.6e-3, ": another path"),
])  # fmt: skip
def test_same_path_but_further_is_told_from_another_path(
    other: list[Vertex], size: float, told: str, tmp_path: Path
) -> None:
    further = compared(tmp_path, STRAIGHT, other, tolerance="0.1 mm")
    common = further.pairs[2].common
    assert common is not None
    assert common.length_a == pytest.approx(4e-3, abs=1e-8)
    assert common.hausdorff == pytest.approx(size, rel=0.02, abs=1e-8)
    assert told in comparison_text(further)
    assert not further.agrees


def test_crack_in_one_only_is_beyond_any_tolerance(tmp_path: Path) -> None:
    a = folder(tmp_path / "a", flaw=STRAIGHT, joint=[(0, 5, 0), (1, 5, 0)])
    b = folder(tmp_path / "b", flaw=STRAIGHT)
    result = compare_paths(a, b, tolerance="1 km")
    assert (result.only_in_a, result.only_in_b, result.agrees) == (("joint",), (), False)
    assert "beyond the tolerance of 1000000.000 mm: joint (only in A)" in comparison_text(result)
    assert compare_paths(a, b).agrees
    assert compare_paths(a, b, tolerance=0, crack="flaw").agrees
    assert compare_paths(b, a, tolerance=0).only_in_b == ("joint",)


@pytest.mark.parametrize("text", [
    "x,y\n0.006,0.0001\n0.008,0.0001\n",
    "x_mm,y_mm\n6,0.1\n8,0.1\n",
    "y_mm;x_cm\n0.1;0.6\n0.1;0.8\n",
    "X [mm]\tY [mm]\n6\t0.1\n8\t0.1\n",
    "# digitised from figure 5\n\nx,y_um\n0.006,100\n\n0.008,100\n",
    "x_mm,y_mm\n8,0.1\n6,0.1\n",
    "\ufeffcrack,vertex,x_mm,y_mm,comment\nflaw,0,6,0.1,first\nflaw,1,8,0.1,last\n",
    "x,y\n6 mm,0.1 mm\n8 mm,0.1 mm\n",
])  # fmt: skip
@pytest.mark.parametrize("tip", [None, "end"])
def test_reference_of_a_part_is_compared_where_it_is(tmp_path: Path, text: str, tip: str | None) -> None:
    run, reference = folder(tmp_path / "run", flaw=STRAIGHT), table(tmp_path / "paper.csv", text)
    (pair,) = compare_paths(run, reference, tip=tip).pairs  # type: ignore[arg-type]
    assert pair.crack == "flaw"
    assert pair.whole is None
    assert pair.deviation.hausdorff == pytest.approx(0.1e-3)
    assert pair.deviation.frechet == pytest.approx(0.1e-3)
    assert pair.common is not None
    assert (pair.common.length_a, pair.common.length_b) == pytest.approx((2e-3, 2e-3))
    assert sorted(pair.common.ends[:, 0]) == pytest.approx([6e-3, 8e-3])
    (turned,) = compare_paths(reference, run, tip=tip).pairs  # type: ignore[arg-type]
    assert turned.deviation.hausdorff == pytest.approx(0.1e-3)
    assert turned.deviation.in_b.step is not None
    assert turned.deviation.in_a.step is None


@pytest.mark.parametrize(("x", "told"), [
    ("6,30", "flaw path: compared 3.000 mm of A, from (6.000, 0.000) to (9.000, 0.000)"),  # cut at the tip
    ("19,29", "beyond the tolerance of 0.001 mm: flaw path (28.000 mm)"),  # as a whole, from the start, -9, to 19
])  # fmt: skip
def test_reference_beyond_the_tip_is_cut_there_and_one_elsewhere_is_not(x: str, told: str, tmp_path: Path) -> None:
    reference = table(tmp_path / "paper.csv", "x_mm,y_mm\n{},0\n{},0\n".format(*x.split(",")))
    result = compare_paths(folder(tmp_path / "run", flaw=STRAIGHT), reference, tolerance="1 um")
    assert told in comparison_text(result)
    assert result.agrees == told.startswith("flaw path")


def test_one_of_several_cracks_and_columns_is_chosen(tmp_path: Path) -> None:
    run = folder(tmp_path / "run", left=STRAIGHT, right=BENT)
    reference = table(tmp_path / "paper.csv", "y_mm,x_mm_fem,x_mm_bem\n0.2,6,7\n0.2,8,7.5\n")
    (pair,) = compare_paths(run, reference, crack="left", columns=("x_mm_fem", "y_mm")).pairs
    assert (pair.crack, pair.deviation.hausdorff) == ("left", pytest.approx(0.2e-3))


def test_case_files_that_differ_are_told(tmp_path: Path) -> None:
    case = "title: A\nnumerics: {spacing: 0.003, support: 2}\nloads:\n- {traction: [0, -1]}\n- {traction: [0, 1]}\n"
    a = folder(tmp_path / "a", case, flaw=STRAIGHT)
    b = folder(tmp_path / "b", case.replace("0.003", "0.0015").replace("-1", "-2") + "plane: strain\n", flaw=STRAIGHT)
    lines = comparison_text(compare_paths(a, b)).splitlines()
    assert lines[2:6] == [
        "settings that differ, A | B:",
        "  numerics.spacing: 0.003 | 0.0015",
        "  loads.0.traction: [0, -1] | [0, -2]",
        "  plane: not given | strain",
    ]
    assert "same settings" in comparison_text(compare_paths(a, a))


def test_csv_has_si_values_and_blanks(tmp_path: Path) -> None:
    a = folder(tmp_path / "a", flaw=STRAIGHT, joint=[(0, 5, 0), (1, 5, 0)])
    b = folder(tmp_path / "b", flaw=BENT)
    rows = list(csv.DictReader(comparison_csv(compare_paths(a, b, tolerance="0.2 mm")).splitlines()))
    assert list(rows[0]) == list(CSV_COLUMNS)
    assert [(row["crack"], row["part"], row["verdict"]) for row in rows] == [
        ("flaw", "given", "within"),
        ("flaw", "start", "within"),
        ("flaw", "end", "beyond"),
        ("joint", "only in A", "beyond"),
    ]
    assert float(rows[2]["hausdorff"]) == pytest.approx(0.3e-3, rel=1e-3)
    assert (rows[0]["common_hausdorff"], rows[3]["hausdorff"]) == ("", "")
    assert float(rows[2]["y_b"]) == pytest.approx(0.3e-3)


def test_exit_code_and_last_line_tell_of_the_tolerance(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    a, b = (str(folder(tmp_path / name, flaw=path)) for name, path in (("a", STRAIGHT), ("b", BENT)))
    assert cli.main(["compare", a, b]) == 0
    out = capsys.readouterr().out.splitlines()
    assert out[-1].startswith("largest: Hausdorff 0.300 mm, Frechet 0.300 mm, flaw end: (7.000, ")
    assert cli.main(["compare", a, b, "--tolerance", "0.31 mm"]) == 0
    assert capsys.readouterr().out.splitlines()[-1] == "within the tolerance of 0.310 mm"
    assert cli.main(["compare", a, b, "--tolerance", "0.00029"]) == 4
    assert capsys.readouterr().out.splitlines()[-1] == "beyond the tolerance of 0.290 mm: flaw end (0.300 mm)"


def line(*points: tuple[float, float]) -> Floats:
    return np.array(points, dtype=float)


POINT, ABOVE = line((0, 0)), line((0, 1), (0, 4))


def test_frechet_sees_the_order() -> None:
    """A line that runs back on itself is near everywhere, but not in the order of a walk: half of the way back."""
    there = line((0, 0), (10, 0))
    back = line((0, 0), (7, 0), (3, 0), (10, 0))
    assert max(farthest(there, back)[0], farthest(back, there)[0]) == 0.0
    assert frechet(there, back) == pytest.approx(2.0, abs=10 / WALKED)
    assert frechet(there, there[::-1]) == pytest.approx(10.0)
    assert frechet(POINT, ABOVE) == 4.0


def frame_of(columns: str, *rows: tuple[str | float, ...]) -> pd.DataFrame:
    return pd.DataFrame([list(row) for row in rows], columns=pd.Index(columns.split()))


def tips(*K: tuple[float, float]) -> pd.DataFrame:
    return frame_of("crack tip K_I K_II", *((f"c{i}", "end", *both) for i, both in enumerate(K)))


def contact(s: np.ndarray, scale: float = 1.0, shift: float = 0.0) -> pd.DataFrame:
    """A pressure of 3, a shear of 4 and an elliptic slip, on a face of length 2; `shift` is added to the pressure."""
    slip = scale * np.sqrt(np.maximum(s * (2 - s), 0.0))
    rows = [("flaw", x, -3.0 + shift, 4.0, y) for x, y in zip(s.tolist(), slip.tolist(), strict=True)]
    return frame_of("crack s normal_traction tangential_traction slip", *rows)


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
        return frame_of("crack s normal_traction tangential_traction slip", *rows)

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
