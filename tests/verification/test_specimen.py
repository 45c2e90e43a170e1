"""Mean stress and strain of the whole specimen: its stress is that of its edges, and its energy that of the rock."""

from __future__ import annotations

import numpy as np
import pytest

from crackgrow.run.scene import make_scene
from crackgrow.run.state_values import specimen_means
from tests.verification.solutions import solved

PULLED = "loads=[{far_field: [0.5, 1, 0.25]}]"


@pytest.mark.parametrize(
    ("scene", "settings", "stress"),
    [
        ("tension0", ("growth.steps=0",), (0.0, 1.0, 0.0)),
        ("compression30", ("growth.steps=0", "cracks.flaw.contact.friction=0.3"), (0.0, -100.0, 0.0)),
        ("junction_static", (PULLED,), (0.5, 1.0, 0.25)),
        ("flaw_and_hole", ("growth.steps=0", PULLED, "loading={history: [1]}"), (0.5, 1.0, 0.25)),
    ],
)
def test_under_uniform_tractions_the_stress_is_theirs_and_the_work_is_that_of_the_means(
    scene: str, settings: tuple[str, ...], stress: tuple[float, float, float]
) -> None:
    """Hill (1963): half of A times stress times strain, with open or slipping cracks and holes."""
    state = solved(scene, *settings).solution.state
    found, strain = map(np.array, specimen_means(state))
    np.testing.assert_allclose(found, 1e6 * np.array(stress), atol=1e-9 * 1e6 * np.abs(stress).max())
    shape = state.scene.case.bodies[0].outline
    area = np.prod(np.ptp(shape, axis=0))
    assert 0.5 * area * (found * [1.0, 1.0, 2.0]) @ strain == pytest.approx(state.energy.work, rel=1e-9)


def test_without_cracks_strains_are_those_of_Hooke_with_in_situ_stress_as_well() -> None:
    """A stress that is there before anything displaces strains nothing; what is added to it does."""
    loads = (
        "loads=[{body: rock, stress: [-3, -2, 0.5], held: true}, {far_field: [-3, -2, 0.5]}, {far_field: [0, 1, 0]}]"
    )
    state = solved("tension0", "growth.steps=0", "cracks={}", loads).solution.state
    stress, strain = specimen_means(state)
    (material,) = make_scene(state.scene.case).materials
    np.testing.assert_allclose(stress, [-3e6, -1e6, 0.5e6], rtol=1e-9)
    xx, yy, twice_xy = np.linalg.solve(material.matrix, [0.0, 1e6, 0.0])
    np.testing.assert_allclose(strain, [xx, yy, 0.5 * twice_xy], atol=1e-12 * abs(yy))
