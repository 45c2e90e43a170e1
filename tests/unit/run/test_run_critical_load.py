"""Critical loads: against fixed factors, and how many solves the search takes."""

from __future__ import annotations

import re
from dataclasses import replace
from operator import attrgetter
from typing import Any

import numpy as np
import pytest

import crackgrow.run.critical_load as critical_load
from crackgrow.case.model import Case
from crackgrow.errors import FreePieceError, NotSolvedError, SolveError
from crackgrow.fracture.advance import GrowingCrack
from crackgrow.run.configuration import Configuration
from crackgrow.run.evaluation import StepSolution, evaluated
from crackgrow.run.increments import held_loads, increment
from crackgrow.run.scene import make_scene
from tests.scenes import shipped_case, specimen
from tests.solving import ready, solve_step, whole_run

CRITICAL = ("loading=critical", "numerics.spacing=3", "growth.tip_stress.radius=2")
MOST_SOLVES = 12


def case_of(name: str, *settings: str) -> Case:
    return shipped_case(name, [*CRITICAL, *settings])


def criticality(solution: StepSolution) -> float:
    return max(tip.verdict.criticality for tip in solution.tips if tip.verdict)


@pytest.fixture
def factors(monkeypatch: pytest.MonkeyPatch) -> list[float]:
    """All load factors that are made for."""
    true, solved = critical_load.rising, []

    def counted(configuration: Any, start: Any, factor: float) -> Any:
        solved.append(factor)
        return true(configuration, start, factor)

    monkeypatch.setattr(critical_load, "rising", counted)
    return solved


def is_first_met(configuration: Configuration, factor: float) -> bool:
    """Whether the criterion is met a little beyond a factor, not a little before it, and nowhere below."""
    start = held_loads(configuration)

    def met(share: float) -> bool:
        return criticality(evaluated(increment(configuration, start, share * factor))) >= 1.0

    return met(1.0 + 1e-6) and not any(met(share) for share in (0.0, 0.35, 0.8, 1.0 - 1e-6))


def test_in_tension_the_critical_load_is_strength_over_stress(factors: list[float]) -> None:
    case = case_of("tension0")
    configuration = ready(case)
    found = critical_load.critically_loaded(configuration, 1.0)
    at_one = solve_step(make_scene(case), configuration.cracks, 1.0)
    stress = max(tip.verdict.sigma_1 for tip in at_one.tips)
    assert found.factor == pytest.approx(0.5e6 / stress, rel=1e-9)
    assert criticality(found) == pytest.approx(1.0, abs=1e-9)
    assert len(factors) == 2
    for guess in (1e-3, 0.7, 40.0, found.factor):
        factors.clear()
        again = critical_load.critically_loaded(configuration, guess)
        assert again.factor == pytest.approx(found.factor, rel=1e-9)
        assert len(factors) <= 2


CLOSED = ("cracks.flaw.contact.friction=0.3", "growth.criterion=directional_strength")


@pytest.mark.parametrize(
    ("cohesion", "kept"), [(0.0, "lost"), (0.1, "lost"), (0.7, "kept"), (0.7, "lost"), (5.0, "lost")]
)
def test_the_critical_load_of_a_closed_crack_is_the_first_that_meets_the_criterion(
    cohesion: float, kept: str, factors: list[float]
) -> None:
    settings = (f"cracks.flaw.contact.cohesion={cohesion}", f"cracks.flaw.contact.cohesion_after_slip={kept}")
    configuration = ready(case_of("compression30", *CLOSED, *settings))
    found = critical_load.critically_loaded(configuration, 1.0)
    assert len(factors) <= MOST_SOLVES
    near = found.factor
    assert is_first_met(configuration, near)
    if kept == "lost" and cohesion > 0.5:  # the flaw lets go at a load that is more than enough for its tips
        assert criticality(found) > 1.5
        shear, pressure = 100e6 * np.sqrt(3.0) / 4.0, 75e6  # on the flaw's plane at factor 1
        assert near == pytest.approx(cohesion * 1e6 / (shear - 0.3 * pressure), rel=2e-3)  # the patch test's error
        assert found.outcome.memory.broken.all()
    else:
        assert criticality(found) == pytest.approx(1.0, abs=1e-9)


@pytest.mark.parametrize("dilation", [0.0, 5.0])
def test_where_only_loads_have_a_size_the_way_to_the_critical_one_does_not_matter(
    dilation: float, factors: list[float]
) -> None:
    settings = (f"cracks.flaw.contact.dilation_angle={dilation}",)
    configuration = ready(case_of("compression30", *CLOSED, *settings))
    found = critical_load.critically_loaded(configuration, 0.07)
    assert len(factors) <= 3
    alone = increment(configuration, held_loads(configuration), found.factor)
    for of in ("outcome.u", "outcome.multipliers", "outcome.memory.slip", "conjugates", "states.tractions"):
        value, known = (attrgetter(of)(state) for state in (found, alone))
        np.testing.assert_allclose(value, known, rtol=0.0, atol=1e-8 * np.abs(known).max(), err_msg=of)
    np.testing.assert_array_equal(found.outcome.points.state, alone.outcome.points.state)
    energies = [(e.work, e.strain, e.dissipated, e.released) for e in (found.energy, alone.energy)]
    np.testing.assert_allclose(*energies, rtol=0.0, atol=1e-9 * energies[0][0])
    later = increment(configuration, found, 1.1 * found.factor)
    assert later.energy.error < 1e-9


def made(cracks: dict[str, Any], size: tuple[float, float], tension: float, **more: Any) -> Configuration:
    """A plate with cracks (mm), of rock of a tensile strength (MPa)."""
    growth = {"steps": 1, "increment": 2, "criterion": "max_hoop_stress", "tip_stress": {"radius": 2}}
    scene = specimen(cracks, size, growth=growth, loading="critical", numerics={"spacing": 2}, **more)
    scene["bodies"]["rock"]["strength"] = {"tension": tension, "cohesion": 100, "friction_angle": 40}
    return ready(Case.from_dict(scene))


def on(edge: str, x: float, y: float, held: bool = False) -> dict[str, Any]:
    return {"on": {"edge": edge}, "traction": [x, y], "held": held}


def sheared(cracks: dict[str, Any], tension: float) -> Configuration:
    """Pressed and sheared."""
    loads = [on("right", 0, 6), on("left", 0, -6), on("top", 6, 0), on("bottom", -6, 0)]
    loads += [on("top", 0, -2, held=True), on("bottom", 0, 2, held=True)]
    return made(cracks, (60.0, 60.0), tension, supports="minimal", loads=loads)


def level(y: float, length: float, cohesion: float, tips: str = "both") -> dict[str, Any]:
    """A level crack that is bonded, without friction."""
    path = {"center": [0, y], "length": length, "angle": 0}
    return {"path": path, "tips": tips, "contact": {"friction": 0, "cohesion": cohesion}}


OPEN = {"path": {"center": [0, 0], "length": 10, "angle": 0}, "contact": "none"}


def test_a_load_that_is_critical_before_bonds_break_is_found_from_any_guess() -> None:
    """A crack with tips between bonded ones: once these slip they shield it."""
    configuration = sheared({"flaw": OPEN, "above": level(4, 24, 9, "none"), "below": level(-4, 24, 9, "none")}, 4)
    found = [critical_load.critically_loaded(configuration, guess) for guess in (0.1, 1.0, 10.0)]
    factors = [solution.factor for solution in found]
    np.testing.assert_allclose(factors, factors[0], rtol=1e-8)
    assert is_first_met(configuration, factors[0])
    start = held_loads(configuration)
    near, beyond = (evaluated(increment(configuration, start, share * factors[0])) for share in (1.01, 1.4))
    flaw = [max(tip.verdict.criticality for tip in solution.tips[:2]) for solution in (near, beyond)]
    assert flaw[0] > 1.0 > flaw[1]  # shielded by the bonds that have broken in between
    assert found[0].outcome.memory.broken.sum() < 0.3 * beyond.outcome.memory.broken.sum()


def pushed(push: float, tension: float) -> Configuration:
    """A block of 40 x 20 mm with a level crack, pressed on a foundation of friction 0.5 and pushed along it."""
    supports = [{"on": {"edge": "bottom"}, "contact": {"friction": 0.5, "cohesion": 0}}]
    loads = [on("top", 0, -10, held=True), on("right", push, 0)]
    return made({"flaw": OPEN}, (40.0, 20.0), tension, supports=supports, loads=loads)


@pytest.mark.parametrize("push", [10.0, 2000.0])
def test_a_guess_beyond_what_friction_holds_does_not_end_the_search(push: float) -> None:
    """A block on a rough foundation slides at a load that does not depend on the unit of the load factor."""
    found = critical_load.critically_loaded(pushed(push, 0.5), 1.0)
    assert push * found.factor == pytest.approx(6.97, rel=1e-3)


@pytest.mark.parametrize("guess", [0.01, 300.0])
def test_a_block_that_slides_before_its_crack_grows_is_free(guess: float) -> None:
    """It is told of at the load at which friction carries all it can: half of the pressure on 40 mm, against 20 mm."""
    with pytest.raises(FreePieceError, match=r"free to move.* before the criterion is met") as found:
        critical_load.critically_loaded(pushed(10.0, 50.0), guess)
    (factor,) = re.findall(r"from a load factor of (\S+) on", str(found.value))
    assert float(factor) == pytest.approx(0.5 * 10.0 * 40.0 / (10.0 * 20.0), rel=2e-3)


HELD = (
    "loads=[{on: {body: rock, edge: top}, traction: [0, -100]}, {on: {body: rock, edge: bottom}, traction: [0, 100]}, "
    "{on: {body: rock, edge: left}, traction: [%g, 0], held: true}, "
    "{on: {body: rock, edge: right}, traction: [%g, 0], held: true}]"
)


def test_lateral_loads_that_are_held_raise_the_critical_load(factors: list[float]) -> None:
    found = []
    for lateral in (0.0, 0.2):
        configuration = ready(case_of("compression30", *CLOSED, HELD % (lateral, -lateral)))
        factors.clear()
        solution = critical_load.critically_loaded(configuration, 1.0)
        assert len(factors) <= MOST_SOLVES
        found.append(solution.factor)
        assert criticality(solution) == pytest.approx(1.0, abs=1e-9)
        assert is_first_met(configuration, found[-1])
    assert found[1] > 1.2 * found[0]
    with pytest.raises(SolveError, match=r"met under the held loads alone.* hold smaller loads"):
        whole_run(case_of("compression30", HELD % (50.0, -50.0)))


@pytest.mark.parametrize(("error", "words"), [(NotSolvedError, "no state was found at"), (SolveError, "^the supports")])
def test_a_state_that_is_not_found_is_none_that_is_not_borne(
    monkeypatch: pytest.MonkeyPatch, error: type[SolveError], words: str
) -> None:
    """Where the solver gives up the search ends short of it and says so; what is wrong at any load ends it at once."""
    configuration = ready(case_of("tension0"))
    exact, tried = critical_load.rising, []

    def gives_up(at: Configuration, start: Any, factor: float) -> Any:
        tried.append(factor)
        if factor > 0.01:
            raise error("the supports contradict each other")
        yield from exact(at, start, factor)

    monkeypatch.setattr(critical_load, "rising", gives_up)
    monkeypatch.setattr(critical_load, "increment", lambda *way: [*gives_up(*way)][-1])
    with pytest.raises(error, match=words) as found:
        critical_load.critically_loaded(configuration, 1.0)
    assert "not borne" not in str(found.value)
    assert "contradict each other" in str(found.value)
    assert (len(tried) == 1) == (error is SolveError)


def test_where_no_load_is_critical_the_run_arrests_and_says_so(factors: list[float]) -> None:
    """A level crack that is pressed flat sticks together: its tips see no tension at any load."""
    case = case_of(
        "tension0", "growth.criterion=max_hoop_stress", "loads.0.traction=[0, -1]", "loads.1.traction=[0, 1]"
    )
    results, end = whole_run(case)
    assert len(results) == 1
    assert end.status == "arrested"
    assert end.reason == f"step 0: {critical_load.NEVER_CRITICAL}"
    assert end.reason.endswith("strength grows with them: `held: true` leaves such a load as it is")
    assert any(critical_load.NEVER_CRITICAL in warning for warning in results[0].warnings)
    assert not any(tip.advanced for tip in results[0].tips)
    assert len(factors) <= 2 + MOST_SOLVES


def test_only_tips_that_can_grow_have_a_critical_load(factors: list[float]) -> None:
    configuration = ready(case_of("tension0", "cracks.flaw.tips=end"))
    (growing,) = configuration.cracks
    only_end = critical_load.critically_loaded(configuration, 1.0)
    assert only_end.tips[1].verdict.criticality == pytest.approx(1.0, abs=1e-9)
    factors.clear()
    (still,) = shipped_case("tension0", ["cracks.flaw.tips=none"]).cracks
    none = critical_load.critically_loaded(replace(configuration, cracks=(GrowingCrack(still, growing.steps),)), 0.7)
    assert (none.factor, factors) == (0.7, [0.7])
