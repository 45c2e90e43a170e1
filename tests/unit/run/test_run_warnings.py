"""What a step warns of, and what it keeps quiet about."""

from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import crackgrow
from crackgrow.case import load_case
from crackgrow.case.segments import line_length
from crackgrow.contact.coulomb import OPEN
from crackgrow.run.loop import grow
from crackgrow.run.result import StepResult
from crackgrow.run.scene import make_scene
from crackgrow.run.step_warnings import contact_violations, step_warnings
from crackgrow.run.warning_causes import StepWarning, limit_of, warning_causes
from tests.scenes import one_size, shipped_case, told
from tests.solving import solve_case


def first_step(scene: str, *settings: str) -> StepResult:
    case = shipped_case(scene, [*one_size(scene), *settings, "output.frames=none", "output.figures=false"])
    return next(grow(case))


def told_of(cause: str, result: StepResult) -> list[StepWarning]:
    return [warning for warning in result.step_warnings if warning.cause == cause]


def test_the_shipped_scenes_warn_of_nothing_but_their_loads() -> None:
    for scene in ("compression30", "tension0"):
        overload, by_hand = first_step(scene).step_warnings
        assert (overload.cause, by_hand.cause) == ("OVERLOAD", "UNMEASURED")
        assert told(first_step(scene, "growth.steps=0").warnings) == []
    stuck = first_step("compression30", "cracks.flaw.contact.friction=0.6")  # its jumps are noise
    assert told(stuck.warnings) == []


def slid(metres: float) -> list[str]:
    """A block, 1 m long, that slides by so much on another one without friction."""
    held = "{on: {body: lower, edge: bottom}, displacement: {x: 0, y: 0}}"
    moved = f"{{on: {{body: upper, edge: top}}, displacement: {{x: {metres}, y: 0}}}}"
    return [
        "interfaces=[{between: [upper, lower], contact: {friction: 0, cohesion: 0}}]",
        f"supports=[{held}, {moved}]",
    ]


def stressed(pressure: float) -> list[str]:
    """Rock that has a stress (MPa) before anything moves, and is held all round."""
    edges = ", ".join(
        f"{{on: {{edge: {edge}}}, displacement: {{x: 0, y: 0}}}}" for edge in ("bottom", "top", "left", "right")
    )
    return [f"loads=[{{body: rock, stress: [-{pressure}, -{pressure}, 0]}}]", f"supports=[{edges}]"]


FLAW, BLOCKS, CAST = "compression30", "interface_friction01", "17_interface"
BONDED = "interfaces=[{between: [concrete, rock], contact: {friction: 0.6}, cracked: [[-17.3205, -10], [17.3205, 10]]}]"
ROCK = "bodies.rock.strength={tension: 5, cohesion: 20, friction_angle: 40}"
GROWS = "growth={steps: 1, increment: 5, criterion: max_hoop_stress, tip_stress: {radius: 1}, initiation: outlines}"
POINTS = ["numerics.spacing=3"]
SHORTENED = "7.75e+05 N/m at supports.{}"
EDGE = "{on: {body: rock, edge: bottom}, displacement: {x: 0, y: '0.1*x'}}"
NOT_AS_IT = "{at: [0, -27.5], displacement: {y: 0}}, {at: [3, -27.5], displacement: {y: 0}}"
OFF_IT = "{at: [3, 27.5], displacement: {y: 9}}"


def cohesive(cohesion: float) -> list[str]:
    """The load at which the flaw's bonds break is more than enough for its tips."""
    law = f"cracks.flaw.contact={{friction: 0.3, cohesion: {cohesion}}}"
    return ["loading=critical", "growth.criterion=directional_strength", law]


def starting(increment: float) -> list[str]:
    """Cracks may start at kinks that lie an increment apart, where stress is averaged within 1 mm."""
    return [*POINTS, "growth.initiation=cracks", f"growth.increment={increment}", "growth.tip_stress.radius=1"]


def short_for_shear(share: float) -> list[str]:
    """A toughness in shear with a length that is a share of the flaw: K_II is 1 / sqrt(1 + R / L) of it."""
    scene = make_scene(shipped_case(FLAW))
    flaw, rock = scene.case.cracks[0], scene.case.bodies[0]
    assert rock.strength is not None
    toughness = 0.5 * rock.strength.cohesion * np.sqrt(2.0 * np.pi * share * line_length(flaw.points)) / 1e6
    key = f"bodies.rock.strength.shear_toughness={toughness} MPa sqrt(m)"
    return [*POINTS, "growth.criterion=directional_strength", "growth.initiation=ends", key]


TOLD = {
    "NOT_SMALL": [
        (FLAW, ["bodies.rock.material.young=3 GPa"], ["the loads strain or turn body 'rock' by 3.2 %"]),
        (FLAW, ["bodies.rock.material.young=4 GPa"], []),
        (BLOCKS, slid(0.04), ["the faces of 'upper/lower' part or slip by 4 % of its length"]),
        (FLAW, stressed(350.0), ["the stress in the ground would strain body 'rock' by 3.3 %"]),
    ],
    "UNBALANCED": [
        # half of the lower traction is missing: 50 MPa over 31 mm stand on two points; then a couple
        (FLAW, [*POINTS, "loads.1.traction=[0, 50]"], [SHORTENED.format(0), SHORTENED.format(1)]),
        (FLAW, [*POINTS, "loads.0.traction=[1, -100]", "loads.1.traction=[-1, 100]"], ["supports.0", "supports.1"]),
    ],
    "JUMP": [(FLAW, cohesive(0.0), []), (FLAW, cohesive(5.0), ["jumps to", "jumps to"])],
    "BONDED_TIPS": [
        (CAST, [], []),
        (CAST, [BONDED, "loading={history: [1]}", ROCK, GROWS], ["do not grow"]),
        (CAST, [ROCK, GROWS], []),
    ],
    "UNKNOWN_G": [
        (CAST, ["loads=[{body: rock, stress: [-1, -1, 0]}]"], []),
        (CAST, ["loads=[{body: rock, stress: [-1-x/100, -1, 0]}]"], ["a formula of the place"]),
    ],
    "SHORT_START": [(FLAW, starting(0.9), ["below the averaging radius"]), (FLAW, starting(1.0), [])],
    "WIDE_SHEAR": [(FLAW, short_for_shear(0.045), []), (FLAW, short_for_shear(0.055), ["crack 'flaw'"])],
    "CONTRADICTION": [
        (FLAW, [f"supports=[{EDGE}, {NOT_AS_IT}, {OFF_IT}]"], ["supports.2 holds a point of an edge otherwise than"])
    ],
}
"""Scenes, settings, and words of the warnings, on either side of where each cause begins."""


@pytest.mark.parametrize(
    ("cause", "scene", "settings", "words"), [(cause, *row) for cause, rows in TOLD.items() for row in rows]
)
def test_a_step_tells_of(cause: str, scene: str, settings: list[str], words: list[str]) -> None:
    found = told_of(cause, first_step(scene, *settings))
    assert [word in each.words for word, each in zip(words, found, strict=True)] == [True] * len(words)
    assert all(each.size > 1.5 for each in found if cause == "JUMP")


def test_every_cause_has_its_words_and_is_told_somewhere() -> None:
    table, package = warning_causes(), Path(crackgrow.__file__).parent
    sources = "".join(path.read_text() for room in ("run", "plan") for path in sorted((package / room).glob("*.py")))
    asked = set(re.findall(r'(?:warning|limit_of|StepWarning)\("([A-Z_]+)"', sources))
    assert set(table) - asked <= {"RESIDUAL", "IMBALANCE", "ENERGY", "OVERLOAD", "UNSTABLE"}  # asked for by variables
    assert asked <= set(table)
    assert all({"words", "effect"} <= set(entry) for entry in table.values())


@pytest.mark.parametrize("after", ["kept", "lost"])
def test_cohesion_that_comes_back_with_the_next_load_only_is_told(after: str) -> None:
    """A dilating crack that tension opens slides without it; under a second load it would stick."""
    law = f"{{friction: 1.4, cohesion: 0.1, cohesion_after_slip: {after}, dilation_angle: 30}}"
    base = ["cracks.flaw.path.angle=80", f"cracks.flaw.contact={law}", "numerics.spacing=2"]
    once, twice = (
        list(grow(shipped_case("slant_tension", [*base, f"loading.history={history}"])))[-1]
        for history in ([1.0], [0.5, 1.0])
    )
    told = [words for words in once.warnings if "touch again" in words]
    same = pytest.approx(twice.tips[0].K_I, rel=1e-6) == once.tips[0].K_I
    assert (len(told), same) == ((1, False) if after == "kept" else (0, True))


def test_overlap_is_the_largest_anywhere_and_small_on_a_straight_crack() -> None:
    result = first_step("compression30")
    (faces,) = result.faces
    assert result.overlap == -faces.opening.min()
    assert 0.0 < result.overlap < 5e-3 * np.abs(faces.slip).max()
    soft = first_step("compression30", "numerics.contact.stiffness=100")  # what its pressure closes is none
    assert -soft.faces[0].opening.min() > 1e-7  # m: 74 MPa over 100 E / h
    assert soft.overlap < 5e-3 * np.abs(soft.faces[0].slip).max()
    pulled = first_step("tension0")
    assert pulled.overlap < 1e-12 * pulled.faces[0].opening.max()  # open, but for round-off at its tips


@pytest.mark.parametrize("spacing", [0.25, 0.1, 0.05])
def test_a_block_at_rest_on_a_plane_warns_of_nothing(spacing: float) -> None:
    """Its corners overlap by nearly all of their jump, which is next to nothing, on any lattice."""
    result = next(grow(load_case(Path(__file__).parent / "block_at_rest.yaml", [f"numerics.spacing={spacing}"])))
    (face,) = result.faces
    assert -face.opening.min() > 0.9 * np.hypot(face.opening, face.slip).max()
    assert told(result.warnings) == []


def test_faces_without_contact_that_lie_in_each_other_are_told_first_with_the_size() -> None:
    result = first_step("compression30", "numerics.spacing=3", "cracks.flaw.contact=none")
    assert result.tips[0].K_I < 0.0
    assert result.step_warnings[0].cause == "CONTACT_NONE"
    (face,) = result.faces
    assert f"lie in each other by {-1e3 * face.opening.min():.2g} mm" in result.warnings[0]
    assert told_of("CONTACT_NONE", first_step("tension0", "cracks.flaw.contact=none")) == []


@pytest.mark.parametrize(("direction", "told"), [("explicit", 2), ("implicit", 0)])
def test_a_path_that_saws_is_told_with_the_remedy(direction: str, told: int) -> None:
    settings = ("growth.criterion=max_hoop_stress", "growth.advance=all", f"growth.direction={direction}")
    *_, last = grow(shipped_case(FLAW, [*one_size(FLAW), *settings, "growth.steps=4"]))
    sawing = told_of("SAWING", last)
    assert len(sawing) == told
    assert all("use growth.direction: implicit" in warning.words for warning in sawing)


def test_pressed_faces_that_stand_apart_or_overlap_are_told() -> None:
    """As far as faces that overlap, where three contact points in turn are pressed; not beside one that is open."""
    solution = solve_case(shipped_case("compression30", ["numerics.spacing=3"]))
    _, (face, *_) = solution.along_surfaces
    assert (face.state != OPEN).all()
    opening = np.zeros(len(face.s))
    opening[3] = 0.3 * np.abs(face.slip).max()
    apart = replace(face, opening=opening)
    (missed,) = contact_violations(solution, (apart,))
    assert missed.share > 1.0
    assert f"stand apart under pressure by {1e6 * opening[3]:.2g} um" in missed.warning.words
    state = face.state.copy()
    state[4] = OPEN
    (missed,) = contact_violations(solution, (replace(apart, state=state),))
    assert missed.share == 0.0
    (missed,) = contact_violations(solution, (replace(face, opening=np.full_like(opening, -1e-3), slip=0.0 * opening),))
    assert missed.share == pytest.approx(1.0 / limit_of("OVERLAP"))  # all of the jump
    assert "by 1 mm between contact points, 100 % of their largest jump" in missed.warning.words


@pytest.mark.parametrize(
    ("released", "error", "told"), [(-2e-3, 0.0, 1), (-2e-3, 3e-3, 0), (-2e-5, 0.0, 0), (2e-3, 0.0, 0)]
)
def test_energy_that_nothing_has_given_is_told(released: float, error: float, told: int) -> None:
    """Where it is more than the error of the balance that is stated, and than what is small."""
    solution = solve_case(shipped_case("compression30", ["numerics.spacing=3"]))
    energy = solution.energy
    state = replace(solution, energy=replace(energy, released=released * energy.size, error=error))
    _, faces = solution.along_surfaces
    found = step_warnings(state, faces, (), step=1)
    created = [warning for warning in found if warning.cause == "CREATED"]
    words = f"{released * energy.size:.3g} J/m are released, 0.2 % of the largest energy below zero"
    assert [words in warning.words for warning in created] == [True] * told
