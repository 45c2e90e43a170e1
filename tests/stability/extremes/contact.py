"""Contact: stiffness, friction, cohesion. The flaw at 30 degrees under 100 MPa slides up to a friction of tan(30)."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import product
from math import radians, tan

import numpy as np

from crackgrow.case.checks import STIFFEST_GAUSS
from tests.stability.extremes.measures import K_II_against, uniform
from tests.stability.extremes.scenes import Scenes
from tests.stability.extremes.trial import Trial
from tests.stability.solved import Measure, Solved, against

STRESS = 100e6
"""Pa: the flaw's load."""

K_II = {0.0: 5.74942e6, 0.3: 2.77911e6}
"""Pa sqrt(m): |K_II| of the flaw by friction, rigid contact; conforming finite elements, good to 0.01 %."""

PRESSURE = 74.2098e6
"""Pa: that of the faces at the middle of the flaw, from the same source."""

STICKING = (-STRESS * 0.75, -STRESS * 0.75**0.5 / 2.0)
"""Pa: tractions on the plane of the flaw where nothing slips, -cos(30)^2 and -cos(30) sin(30) of the load."""

LIMIT = tan(radians(30.0))
"""The friction at which the flaw sticks."""

SLIP_TOLERANCE, STICK_TOLERANCE = 1e-2, 1e-6


def stiffness(scenes: Scenes) -> Iterator[Trial]:
    """Elastic contact k = kappa E/h, from soft to rigid."""
    values = scenes.few((1e0, 1e1, 1e2, 1e4, 1e6, 1e8, 1e10, 1e12), (1e0, 1e6, 1e12))
    for discretization, kappa in product(("mortar", "gauss"), values):
        yield Trial(
            "stiffness",
            f"{kappa:g} E/h, {discretization}",
            "K_II of rigid contact (finite elements), K_I = -p sqrt(E'/(2k))",
            2.0 * SLIP_TOLERANCE,
            scenes.solved_flaw(*_contact(kappa, discretization)),
            elastic_K(kappa),
            scenes.usual_flaw(),
            refusable=discretization == "gauss" and kappa > STIFFEST_GAUSS,
        )
    yield _sliding(scenes, "stiffness", "rigid, mortar", 0.0, ())


def friction(scenes: Scenes) -> Iterator[Trial]:
    """From none to far beyond what makes the flaw stick."""
    for value in (0.0, 0.3):
        yield _sliding(scenes, "friction", f"{value:g}", value, (f"cracks.flaw.contact.friction={value}",))
    for value in scenes.few((LIMIT, 2.0, 10.0, 1e3), (LIMIT, 1e3)):
        name = "tan(30 deg)" if value == LIMIT else f"{value:g}"
        yield _sticking(scenes, "friction", name, (f"cracks.flaw.contact.friction={value!r}",))


def cohesion(scenes: Scenes) -> Iterator[Trial]:
    """A cohesion that breaks is lost; one that holds glues the flaw."""
    for text in ("0 MPa", "1 MPa"):
        yield _sliding(scenes, "cohesion", text, 0.0, (f"cracks.flaw.contact.cohesion={text}",))
    yield _sticking(scenes, "cohesion", "1 GPa", ("cracks.flaw.contact.cohesion=1 GPa",))


def stiffness_and_friction(scenes: Scenes) -> Iterator[Trial]:
    """Both at once: the flaw slides as under rigid contact, within what the stiffness gives way."""
    for kappa, mu in product(scenes.few((1e2, 1e6, 1e12), (1e12,)), (0.3, 2.0)):
        friction = f"cracks.flaw.contact.friction={mu}"
        plain = scenes.usual_flaw(friction)
        yield Trial(
            "stiffness x friction",
            f"{kappa:g} E/h, {mu:g}",
            "K_II of rigid contact with the same friction",
            2.0 * SLIP_TOLERANCE,
            scenes.solved_flaw(*_contact(kappa, "mortar"), friction),
            against(plain, _of_sliding_K_II),
            scenes.usual_flaw(),
        )


def _contact(kappa: float, discretization: str) -> tuple[str, str]:
    return f"numerics.contact.stiffness={kappa!r}", f"numerics.contact.discretization={discretization}"


def _of_sliding_K_II(found: Solved, plain: Solved) -> float:
    """Difference of K_II by that of the flaw without friction."""
    return float(np.abs(found.K[:, 1] - plain.K[:, 1]).max() / K_II[0.0])


def elastic_K(kappa: float) -> Measure:
    """Error of K_II, and of the K_I that faces which overlap by p/k have at their tips, by K_II of rigid contact."""

    def measure(found: Solved) -> float:
        scene = found.solution.scene
        young_prime, k = (
            scene.materials[0].young_prime,
            kappa * found.case.bodies[0].material.young / scene.lattice.spacing,
        )
        spurious = -PRESSURE * np.sqrt(young_prime / (2.0 * k))
        errors = [found.K[:, 0] - spurious, np.abs(found.K[:, 1]) - K_II[0.0]]
        return float(np.abs(errors).max() / K_II[0.0])

    return measure


def _sliding(scenes: Scenes, axis: str, value: str, mu: float, settings: tuple[str, ...]) -> Trial:
    return Trial(
        axis,
        value,
        "K_II (finite elements), K_I = 0",
        SLIP_TOLERANCE,
        scenes.solved_flaw(*settings),
        K_II_against(K_II[mu]),
        scenes.usual_flaw(),
    )


def _sticking(scenes: Scenes, axis: str, value: str, settings: tuple[str, ...]) -> Trial:
    return Trial(
        axis,
        value,
        "uniform tractions, K = 0 (exact)",
        STICK_TOLERANCE,
        scenes.solved_flaw(*settings),
        uniform(*STICKING),
        scenes.usual_flaw(),
    )
