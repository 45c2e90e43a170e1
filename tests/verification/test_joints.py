"""Joints in closed form: elastic, closing by a hyperbola, bearing tension, rough, weakening or worn by slip.

A block on a joint under a pressure p and a shear q closes by p / k_n, or by p / (k + p / v_m), and slips by q / k_s
(Goodman, Taylor, Brekke 1968; Bandis). Rough joints slide at p tan(phi + JRC log10(JCS / p)) (Barton). A stiff block
under a displacement d has the slip s = d - shear / k; under wear the shear is p mu(s), and the block rises by the
integral of tan(dilation angle) over all slip, less p / k_n. Nothing depends on the lattice.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import pytest
from scipy.optimize import brentq

from crackgrow.contact.coulomb import SLIP
from crackgrow.run.loop import solved_steps
from crackgrow.run.result import StepResult
from tests.scenes import shipped_case
from tests.solving import seen, whole_run
from tests.verification.solutions import case_of, solved


@pytest.fixture(params=["condensed", "factors"])
def rock(request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch) -> None:
    """Few contact points are solved for as many are, too."""
    if request.param == "factors":
        monkeypatch.setattr("crackgrow.contact.system.MOST_CONDENSED", 0)
        monkeypatch.setattr("crackgrow.contact.solve.MANY", 0)


def last(result: StepResult, column: str) -> float:
    """A column of history.csv at the end of a step."""
    return float(seen([result], column)[-1])


def factors_of(results: Sequence[StepResult]) -> np.ndarray:
    """Load factors, on the way of all steps."""
    return np.concatenate([result.history.load_factor for result in results if result.history is not None])


# A flat, stiff block on a joint, that moves as one: what the joint does is a closed form of how it is moved.

WIDTH, SHEAR, NORMAL, PRESSURE = 0.1, 1e10, 1e12, 2e6  # m, Pa/m, Pa/m, Pa
SOFT = "stiffness: {normal: 1e12, shear: 1e10}"

STIFF = """
title: a flat, stiff block, sheared
plane: stress
bodies:
  top: {shape: {rectangle: {center: [0, 0.001], width: 0.1, height: 0.002}}, material: {young: 1e14, poisson: 0}}
supports:
  - {on: {body: top, edge: bottom}, contact: {LAW}}
  - {on: {body: top, edge: top}, displacement: {MOVED}}
loads: [{on: {body: top, edge: top}, traction: [0, -PRESSURE], held: true}]
numerics: {spacing: 0.001, contact: {spacing: 4}}
output: {points: {joint: {at: [0, 0.002]}}}
"""


def sheared(law: str, moved: str, *settings: str, pressure: float = PRESSURE) -> list[StepResult]:
    """The steps of the block on a joint with a law, its top moved so far (m) and pressed by a pressure (Pa)."""
    return whole_run(case_of(STIFF, *settings, LAW=law, MOVED=moved, PRESSURE=pressure))[0]


@pytest.mark.usefixtures("rock")
def test_slip_beyond_friction_is_not_elastic() -> None:
    """Sheared by d and back to none, a joint that has slipped by s = d - mu p / k_s is sheared by k_s s the other way.

    The block turns a little, by its height times which its base slips less than its top: 0.2 % of the slip, each way.
    """
    law = "friction: 0.6, cohesion: 0, stiffness: {normal: 2e10, shear: 5e9}"
    there, back = (
        last(result, "supports.1.force_x") / 0.1
        for result in sheared(law, "x: 0.0006", "loading={history: [1, 0]}", pressure=3e6)
    )
    assert there == pytest.approx(0.6 * 3e6, rel=1e-4)
    assert back == pytest.approx(-(5e9 * 0.0006 - 0.6 * 3e6), rel=5e-3)


def test_slip_takes_tensile_strength_as_it_takes_cohesion() -> None:
    """Under displacements d and g of a stiff block slip s takes s / D of c and T; it opens where k_n g is what is left.

    With k the shear stiffness k (d - s) = c (1 - s / D) - mu k_n g where it slips.
    """
    law = f"friction: 0.8, cohesion: 5e6, tension: 2e6, weakening_length: 0.002, {SOFT}"
    found = sheared(law, "x: 0.003, y: 1e-6", pressure=0.0)
    factor, shear = factors_of(found), seen(found, "supports.1.force_x") / WIDTH
    d = 0.003 * factor
    slip = (1e10 * d - 5e6 + 0.8 * 1e6 * factor) / (1e10 - 5e6 / 0.002)
    expected = np.where(slip < 0.0, 1e10 * d, 1e10 * (d - slip))
    opens = factor[np.argmax(2e6 * (1.0 - slip / 0.002) < 1e6 * factor)]
    before = factor < 0.999 * opens
    assert np.sum(before) > 20
    np.testing.assert_allclose(shear[before], expected[before], rtol=1e-3)
    assert np.abs(shear[factor > 1.001 * opens]).max() < 1e-6 * shear.max()
    assert 0.5 < opens < 0.55


@pytest.mark.usefixtures("rock")
def test_points_open_one_after_the_other() -> None:
    """A block that is lifted at one edge opens its joint to where p = k g is the strength; the rest holds as before."""
    law = "friction: 0.8, cohesion: 5e6, tension: 1e6, stiffness: {normal: 1e12, shear: 1e12}"
    settings = ("numerics.contact={}", "loading={history: [1]}")
    (result,) = sheared(law, 'y: "2e-6*(0.5+x/0.1)"', *settings, pressure=0.0)
    assert result.energy.released == pytest.approx(0.5 * 1e6**2 / 1e12 * 0.1 * 0.5, rel=0.03)
    assert last(result, "supports.1.force_y") == pytest.approx(0.5 * 1e6 * 0.05, rel=0.06)
    assert result.energy.error < 1e-8


# Wear: `rough_joint_sheared`, whose friction and dilation decay, and a table.

PULLED, DECAY, STEEP = 6e-3, 2e-3, np.tan(np.deg2rad(15.0))


def worn(results: Sequence[StepResult], width: float = 0.4) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Slip (m), shear stress (Pa) and rise (m), on the way of all steps."""
    shear = seen(results, "supports.1.force_x") / width
    return PULLED * factors_of(results) - shear / SHEAR, shear, seen(results, "joint.u_y") + PRESSURE / NORMAL


def test_friction_and_dilation_decay_with_slip_and_faces_close_again_by_what_is_left() -> None:
    results = whole_run(shipped_case("rough_joint_sheared", ["loading.follow=events"]))[0]
    slip, shear, rise = worn(results[:2])
    slides, decayed = slip > 1e-4, np.exp(-slip / DECAY)
    assert np.sum(slides) > 20
    np.testing.assert_allclose(shear[slides], (PRESSURE * (0.5 + 0.3 * decayed))[slides], rtol=1e-3)
    expected = (STEEP * DECAY * (1.0 - decayed))[slides]
    np.testing.assert_allclose(rise[slides], expected, atol=1e-3 * expected.max())
    assert max(result.energy.error for result in results) < 1e-7
    assert abs(results[-1].energy.released) < 1e-8 * results[-1].energy.work
    back = [each[-1] for each in worn(results[2:])]
    left = np.exp(-(2.0 * slip[-1] - back[0]) / DECAY)
    assert back[1] == pytest.approx(-PRESSURE * (0.5 + 0.3 * left), rel=1e-3)
    assert back[2] == pytest.approx(rise[-1] - STEEP * DECAY * (decayed[-1] - left), rel=1e-3)


@pytest.mark.parametrize("follow", ["events", 1])
def test_a_table_is_followed(follow: str | int) -> None:
    wear = "wear: {slip: [1 mm, 3 mm], friction: [0.6, 0.5], dilation_angle: [6, 0]}"
    law = f"friction: 0.8, dilation_angle: 15, {SOFT}, {wear}"
    results = sheared(law, "x: 0.006", f"loading={{history: [0.25, 0.5, 1], follow: {follow}}}")
    slip, shear, rise = worn(results, WIDTH)
    at, places = [0.0, 1e-3, 3e-3], np.linspace(0.0, PULLED, 60001)
    steep = np.interp(places, at, np.tan(np.deg2rad([15.0, 6.0, 0.0])))
    risen = np.append(0.0, np.cumsum(0.5 * (steep[1:] + steep[:-1]) * np.diff(places)))
    slides = slip > 1e-4
    np.testing.assert_allclose(shear[slides], PRESSURE * np.interp(slip, at, [0.8, 0.6, 0.5])[slides], rtol=1e-3)
    np.testing.assert_allclose(rise[slides], np.interp(slip, places, risen)[slides], rtol=1e-3)
    assert follow != "events" or max(result.energy.error for result in results) < 1e-7


# Elastic joints between blocks, and of a crack.

YOUNG = 1e10  # Pa; Poisson's ratio is zero: shear modulus E/2
TWO_BLOCKS = """
title: two blocks and a joint
plane: stress
units: {stress: MPa}
bodies:
  low: {shape: {rectangle: {center: [0, -0.05], width: 0.1, height: 0.1}}, material: {young: 1e4, poisson: 0}}
  top: {shape: {rectangle: {center: [0, 0.05], width: 0.1, height: 0.1}}, material: {young: 1e4, poisson: 0}}
interfaces:
  - {between: [top, low], contact: {friction: 0.6, cohesion: 0, stiffness: {normal: 20 GPa/m, shear: 5000}}}
supports: [{on: {body: low, edge: bottom}, displacement: {x: 0, y: 0}}]
loads:
  - {on: {body: top, edge: top}, traction: [1, -3]}
  - {on: {body: top, edge: left}, traction: [0, -1]}
  - {on: {body: top, edge: right}, traction: [0, 1]}
  - {on: {body: low, edge: left}, traction: [0, -1]}
  - {on: {body: low, edge: right}, traction: [0, 1]}
output: {points: {joint: {interface: [top, low], at: [0.02, 0]}}}
"""


@pytest.mark.parametrize("spacing", [0.05, 0.013])
def test_a_joint_between_blocks_closes_and_slips_by_its_stiffness(spacing: float) -> None:
    (result,) = whole_run(case_of(TWO_BLOCKS, f"numerics.spacing={spacing}"))[0]
    assert last(result, "joint.opening") == pytest.approx(-3e6 / 2e10, rel=1e-8)
    assert abs(last(result, "joint.slip")) == pytest.approx(1e6 / 5e9, rel=1e-8)
    np.testing.assert_allclose(result.contact.normal_traction, -3e6, rtol=1e-7)
    np.testing.assert_allclose(np.abs(result.contact.tangential_traction), 1e6, rtol=1e-7)
    strain_energy = 0.1 * (3e6**2 / 2e10 + 1e6**2 / 5e9) / 2.0
    strain_energy += 0.02 * (3e6**2 + 2.0 * 1e6**2) / (2.0 * YOUNG)
    assert result.energy.strain == pytest.approx(strain_energy, rel=1e-8)
    assert result.energy.error < 1e-9


def test_stiffness_of_a_crack_is_that_of_the_numerics_where_it_is_the_same() -> None:
    """kappa E / h, given in one way or the other."""
    given = [f"cracks.flaw.contact.stiffness.{way}={100.0 * 10000.0}" for way in ("normal", "shear")]  # MPa/mm
    one, other = (
        solved("compression30", "numerics.spacing=1", *more).result
        for more in (["numerics.contact.stiffness=100"], given)
    )
    for tip, like in zip(one.tips, other.tips, strict=True):
        assert pytest.approx((like.K_I, like.K_II), rel=1e-9) == (tip.K_I, tip.K_II)
    np.testing.assert_allclose(one.contact.normal_traction, other.contact.normal_traction, rtol=1e-9)


# Bandis and Barton.

BANDIS_WIDTH, STIFFNESS, CLOSURE = 0.4, 20e9, 2e-4  # m, Pa/m, m


def stored(pressure: float) -> float:
    """J/m^2: the integral of p dv."""
    k = STIFFNESS * CLOSURE
    closure = pressure / (STIFFNESS + pressure / CLOSURE)
    return pressure * closure - CLOSURE * (pressure - k * np.log1p(pressure / k))


@pytest.mark.parametrize("follow", ["events", 5])
def test_closure_is_a_hyperbola_there_and_back(follow: str | int) -> None:
    pressed = ["loads.0.held=false", "supports.1.displacement.x=0", "loads.0.traction=[0, -20]"]
    loading = f"loading={{history: [0.1, 0.5, 1, 0.3], follow: {follow}}}"
    results = whole_run(shipped_case("barton_bandis", [*pressed, loading]))[0]
    rise, pressure = seen(results, "joint.u_y"), np.abs(seen(results, "top.bottom.force_y")) / BANDIS_WIDTH
    closure = pressure / (STIFFNESS + pressure / CLOSURE)
    assert len(pressure) >= 20
    assert closure.max() > 0.8 * CLOSURE
    np.testing.assert_allclose(-rise, closure, rtol=1e-3)
    energy = results[-1].energy
    assert energy.strain == pytest.approx(BANDIS_WIDTH * stored(0.3 * 20e6), rel=1e-3)
    assert energy.dissipated == 0.0
    assert follow != "events" or energy.error < 1e-6


@pytest.mark.parametrize("pressure", [0.005, 50])
def test_shear_strength_is_that_of_the_pressure(pressure: float) -> None:
    """Faces are no steeper than 70 degrees and no flatter than flat."""
    settings = [f"loads.0.traction=[0, {-pressure}]", "supports.1.displacement.x=20", "loading.follow=events"]
    (result,) = whole_run(shipped_case("barton_bandis", settings))[0]
    angle = np.clip(30.0 + 10.0 * np.log10(100.0 / pressure), 30.0, 70.0)
    strength = 1e6 * pressure * np.tan(np.deg2rad(angle))
    assert last(result, "supports.1.force_x") == pytest.approx(BANDIS_WIDTH * strength, rel=1e-3)
    assert result.energy.error < 1e-6


@pytest.mark.usefixtures("rock")
def test_under_loads_that_press_and_shear_at_once_faces_slip_at_their_strength() -> None:
    """Near no pressure friction bends so much that events were looked for in vain, and faces stuck beyond it."""
    law = "cracks.flaw.contact={friction: 0.2, cohesion: 0, barton: {jrc: 10, jcs: 50}}"
    settings = [law, "numerics.spacing=1", "growth.steps=0", "loading={history: [1]}", "output.frames=none"]
    *_, (_, solution) = solved_steps(shipped_case("compression30", settings))
    points = solution.outcome.points
    friction, _ = solution.configuration.contact.law.bound_of(points.trial.lost, points.normal)
    assert (points.state == SLIP).all()
    np.testing.assert_allclose(np.abs(points.tangential), -friction * points.normal, rtol=1e-6)


# Tension.


@pytest.mark.usefixtures("rock")
def test_a_vein_opens_at_its_tensile_strength_and_then_has_none() -> None:
    """Pulled by half of 40 micrometres, then by all, then pressed: it has the stress of rock before, and pressed."""
    area, length, elastic = 0.05, 0.1, 0.5 * 4e-5 / 0.1 * YOUNG * 0.05  # m, m, N/m
    peak = 2e6 / np.cos(np.deg2rad(20.0)) ** 2  # Pa, of axial stress
    before, broken, pressed = whole_run(shipped_case("vein_in_tension"))[0]
    assert last(before, "supports.1.force_y") == pytest.approx(elastic, rel=1e-9)
    force = seen([broken], "supports.1.force_y")
    assert force.max() == pytest.approx(peak * area, rel=1e-3)
    assert abs(force[-1]) < 1e-9 * peak * area
    assert broken.energy.released == pytest.approx(0.5 * peak**2 / YOUNG * area * length, rel=1e-3)
    assert max(result.energy.error for result in (before, broken, pressed)) < 1e-8
    assert last(pressed, "supports.1.force_y") == pytest.approx(-elastic, rel=1e-9)
    again = whole_run(shipped_case("vein_in_tension", ["loading.history=[1, -0.5, 0.4]"]))[0][-1]
    assert abs(last(again, "supports.1.force_y")) < 1e-9 * peak * area


# A specimen cut through by a joint, pressed between smooth platens: it slides as one, and stress is uniform.
#
# Under a closure d of its height H and a lateral pressure p the axial stress q and the slip s at an angle b follow from
#
#     d = (A q - B p) H + s sin b - |s| tan psi cos b,      A = (1 - nu^2) / E,  B = nu (1 + nu) / E,
#     (q - p) sin b cos b = +- (c + mu (q cos^2 b + p sin^2 b))     where it slides,
#
# with c and mu at the slip that has been, and the energies by quadrature over that slip.

HEIGHT, CLOSES, LATERAL = 0.2, 1e-3, 2e6  # m, m, Pa
SIN, COS = np.sin(np.deg2rad(55.0)), np.cos(np.deg2rad(55.0))
REACH = 0.05 * SIN / COS  # m: of the joint above and below the middle
A, B = (1.0 - 0.25**2) / 20e9, 0.25 * 1.25 / 20e9
FRICTION, RESIDUAL, COHESION = 0.8, 0.5, 1.5e6

SPECIMEN = f"""
title: a specimen cut through by a joint
plane: strain
materials: {{rock: {{young: 20 GPa, poisson: 0.25}}}}
bodies:
  low: {{shape: {{polygon: [[-0.05, -0.1], [0.05, -0.1], [0.05, {REACH}], [-0.05, {-REACH}]]}}, material: rock}}
  top: {{shape: {{polygon: [[-0.05, {-REACH}], [0.05, {REACH}], [0.05, 0.1], [-0.05, 0.1]]}}, material: rock}}
interfaces:
  - between: [low, top]
    contact: {{friction: 0.8, residual_friction: 0.5, cohesion: 1.5e6, weakening_length: 0.0004}}
supports:
  - {{on: {{body: low, edge: 0}}, displacement: {{y: 0}}}}
  - {{at: [-0.05, -0.1], displacement: {{x: 0}}}}
  - {{on: {{body: top, edge: 2}}, displacement: {{y: -0.001}}}}
loads:
  - {{on: {{body: low, edge: 1}}, pressure: 2 MPa, held: true}}
  - {{on: {{body: low, edge: 3}}, pressure: 2 MPa, held: true}}
  - {{on: {{body: top, edge: 1}}, pressure: 2 MPa, held: true}}
  - {{on: {{body: top, edge: 3}}, pressure: 2 MPa, held: true}}
numerics: {{spacing: 0.05}}
output: {{points: {{joint: {{at: [0, 0], interface: [low, top]}}}}}}
"""
FORTH_AND_BACK = (0.2, 0.3, 0.25, 0.5, 0.4, 0.3, 1.0, 0.5, 0.8)


@dataclass
class Joint:
    """The closed form."""

    weakening: float
    dilation: float = 0.0
    kept: bool = False
    slip: float = 0.0
    lost: float = 0.0
    dissipated: float = 0.0  # J/m

    @property
    def law(self) -> dict[str, object]:
        angle, kept = float(np.rad2deg(np.arctan(self.dilation))), "kept" if self.kept else "lost"
        return {"weakening_length": self.weakening, "dilation_angle": angle, "cohesion_after_slip": kept}

    def closure(self, q: float, slip: float) -> float:
        return (A * q - B * LATERAL) * HEIGHT + slip * SIN - self.dilation * abs(slip) * COS

    def sliding(self, way: int, lost: float) -> float:
        """q where it slides."""
        friction = FRICTION + (RESIDUAL - FRICTION) * lost
        cohesion = COHESION * (1.0 if self.kept else 1.0 - lost)
        shear = cohesion + friction * LATERAL * SIN**2
        return (way * shear + LATERAL * SIN * COS) / (SIN * COS - way * friction * COS**2)

    def press(self, d: float) -> float:
        """q after a closure."""
        q = (d - self.closure(0.0, self.slip)) / (A * HEIGHT)
        for way in (1, -1):
            if way * (q - self.sliding(way, self.lost)) > 0.0:
                return self._slide(d, way)
        return q

    def _slide(self, d: float, way: int) -> float:
        def lost(more: float) -> float:
            return min(1.0, self.lost + abs(more) / self.weakening)

        more = brentq(
            lambda x: self.closure(self.sliding(way, lost(x)), self.slip + x) - d, 0.0, way * 0.005, xtol=1e-18
        )
        share = (np.arange(200) + 0.5) / 200
        q = np.array([self.sliding(way, lost(x)) for x in share * more])
        shear, pressure = (q - LATERAL) * SIN * COS, q * COS**2 + LATERAL * SIN**2
        opened = self.dilation * (abs(self.slip + more) - abs(self.slip))
        self.dissipated += float(np.mean(shear) * more - np.mean(pressure) * opened) * WIDTH / COS
        self.slip, self.lost = self.slip + more, lost(more)
        return float(self.sliding(way, self.lost))


def steps(joint: Joint, factors: tuple[float, ...]) -> list[StepResult]:
    law = [f"interfaces.0.contact.{key}={value}" for key, value in joint.law.items()]
    return whole_run(case_of(SPECIMEN, f"loading.history={list(factors)}", *law))[0]


def axial(result: StepResult) -> float:
    """Pa, of the upper platen at the end of a step."""
    return -last(result, "supports.2.force_y") / WIDTH


@pytest.mark.parametrize(("weakening", "dilation", "kept"), [(4e-4, 0.14, True), (2e-3, 0.14, False)])
def test_it_slides_forth_and_back_as_the_closed_form_does(weakening: float, dilation: float, kept: bool) -> None:
    joint = Joint(weakening, dilation, kept)
    found = steps(joint, FORTH_AND_BACK)
    assert len(found) == len(FORTH_AND_BACK)
    for before, factor, result in zip((0.0, *FORTH_AND_BACK), FORTH_AND_BACK, found, strict=False):
        for d in CLOSES * np.linspace(before, factor, 50)[1:]:
            q = joint.press(d)
        assert axial(result) == pytest.approx(q, rel=2e-4)
        np.testing.assert_allclose(np.abs(result.contact.mean_slip), joint.slip, atol=1e-9)
        np.testing.assert_allclose(result.contact.mean_opening, joint.dilation * joint.slip, atol=1e-9)
        assert result.energy.error < 1e-9
        assert abs(result.energy.released) < 1e-9 * max(result.energy.work, 1.0)
        assert result.energy.dissipated == pytest.approx(joint.dissipated, rel=1e-4, abs=1e-6)


@pytest.mark.parametrize(("weakening", "dilation"), [(1e-4, 0.0), (1e-5, 0.14), (1e-7, 0.14)])
def test_a_sudden_slip_releases_what_the_weakening_joint_does_not_take(weakening: float, dilation: float) -> None:
    """Strength falls faster with slip than the specimen unloads: at the peak it slides at once to the residual law."""
    joint = Joint(weakening, dilation)
    (end_step,) = steps(joint, (0.3,))
    peak, residual = joint.sliding(1, 0.0), joint.sliding(1, 1.0)
    onset = joint.closure(peak, 0.0)
    jump, end = ((d - joint.closure(residual, 0.0)) / (SIN - dilation * COS) for d in (onset, 0.3 * CLOSES))
    slip = np.concatenate([np.linspace(0.0, min(weakening, jump), 2001), np.linspace(min(weakening, jump), jump, 2001)])
    lost = np.minimum(1.0, slip / weakening)
    pressure = (peak + (residual - peak) * slip / jump) * COS**2 + LATERAL * SIN**2
    shear = COHESION * (1.0 - lost) + (FRICTION + (RESIDUAL - FRICTION) * lost) * pressure
    after = COS**2 * residual + LATERAL * SIN**2
    taken = np.trapezoid(shear - dilation * pressure, slip) + (RESIDUAL - dilation) * after * (end - jump)
    assert axial(end_step) == pytest.approx(residual, rel=1e-6)
    assert end_step.energy.dissipated == pytest.approx(taken * WIDTH / COS, rel=1e-4)
    assert end_step.energy.released > 0.05 * end_step.energy.dissipated
    assert end_step.history is not None
    assert len(end_step.history.load_factor) < 20
