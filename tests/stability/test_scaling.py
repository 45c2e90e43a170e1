"""Young's modulus from 1 Pa to 1e12 Pa, specimens from a micrometre to ten kilometres, loads from 1e-6 to 1e9 Pa.

Results over their units must be the same: K/(sigma sqrt(a)), u E/(sigma a), tractions/sigma, states, criticality, kinks
and paths. The cases are written as files in SI: what the reader does to numbers is part of it.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from pathlib import Path

import numpy as np
import pytest
import yaml

from crackgrow.case import load_case
from crackgrow.run import grow
from crackgrow.run.result import StepResult
from tests.stability.placed import placed, scaled
from tests.stability.solved import everything, solved

CASES = Path(__file__).parents[2] / "cases"

YOUNG, WIDTH, STRESS = 10e9, 31e-3, 100e6  # of the flaw as it is: Pa, m, Pa
SAME = 1e-8
KINK = 1e-6  # degrees

EXTREMES = {
    "1 Pa": (1.0 / YOUNG, 1.0, 1.0),
    "1e12 Pa": (1e12 / YOUNG, 1.0, 1.0),
    "1 um": (1.0, 1e-6 / WIDTH, 1.0),
    "10 km": (1.0, 1e4 / WIDTH, 1.0),
    "load 1e-6 Pa": (1.0, 1.0, 1e-6 / STRESS),
    "load 1e9 Pa": (1.0, 1.0, 1e9 / STRESS),
}
"""Factors of modulus, size and stress."""

TOGETHER = {
    "soft, large, much load": (1.0 / YOUNG, 1e4 / WIDTH, 1e9 / STRESS),
    "stiff, small, little load": (1e12 / YOUNG, 1e-6 / WIDTH, 1e-6 / STRESS),
}

GAUSS = {"stiffness": 1000.0, "discretization": "gauss"}
SCENES: dict[str, dict[str, object]] = {
    "frictionless": {},
    "friction": {"contact": {"friction": 0.3, "cohesion": 0.0}, "growth": {"criterion": "strength"}},
    "cohesion": {"contact": {"friction": 0.3, "cohesion": 10.0, "cohesion_after_slip": "kept"}},
    "elastic contact": {"contact": {"friction": 0.3, "cohesion": 0.0}, "numerics": GAUSS},
    "lemke": {"contact": {"friction": 0.3, "cohesion": 0.0}, "numerics": {"solver": "lemke"}},
    "implicit": {"growth": {"criterion": "max_hoop_stress", "direction": "implicit"}},
    "load stays": {"contact": {"friction": 0.3, "cohesion": 0.0}, "growth": {"unload_between_steps": False}},
    "critical load": {"contact": {"friction": 0.3, "cohesion": 0.0}, "loading": "critical"},
}
"""What differs from the flaw of compression30; cohesion in MPa."""


def case_text(scene: dict[str, object], young: float, size: float, stress: float) -> str:
    """compression30 at a spacing of 3 mm and two steps of growth, in SI, with everything multiplied."""
    half, top = 15.5e-3 * size, 27.5e-3 * size
    contact = {"friction": 0.0, "cohesion": 0.0, **scene.get("contact", {})}
    contact["cohesion"] = 1e6 * stress * contact["cohesion"]
    growth = {"steps": 2, "increment": 2e-3 * size, "advance": "most_critical", "criterion": "directional_strength"}
    case = {
        "title": "Flaw in units of its own",
        "units": {"length": "m", "stress": "Pa"},
        "plane": "strain",
        "bodies": {
            "rock": {
                "shape": {"rectangle": {"center": [0.0, 0.0], "width": 2.0 * half, "height": 2.0 * top}},
                "material": {"young": YOUNG * young, "poisson": 0.25},
                "strength": {"tension": 0.5e6 * stress, "cohesion": 10e6 * stress, "friction_angle": 40},
            }
        },
        "cracks": {
            "flaw": {
                "path": {"center": [0.0, 0.0], "length": 10e-3 * size, "angle": 30},
                "tips": "both",
                "contact": contact,
            }
        },
        "supports": [
            {"at": [-half, -top], "displacement": {"y": 0}},
            {"at": [half, -top], "displacement": {"y": 0}},
            {"at": [0.0, -top], "displacement": {"x": 0}},
        ],
        "loads": [
            {"on": {"body": "rock", "edge": "top"}, "traction": [0.0, -STRESS * stress]},
            {"on": {"body": "rock", "edge": "bottom"}, "traction": [0.0, STRESS * stress]},
        ],
        "growth": {**growth, "tip_stress": {"radius": 2e-3 * size}, **scene.get("growth", {})},
        "loading": scene.get("loading", {"history": [1.0]}),
        "numerics": {"spacing": 3e-3 * size, "contact": scene.get("numerics", {})},
        "output": {"frames": "none", "figures": False},
    }
    return yaml.safe_dump(case)


def steps(folder: Path, scene: dict[str, object], young: float, size: float, stress: float) -> list[StepResult]:
    path = folder / "scaled.yaml"
    path.write_text(case_text(scene, young, size, stress), encoding="utf-8")
    return list(grow(load_case(path)))


def over_units(result: StepResult, young: float, size: float, stress: float) -> dict[str, np.ndarray]:
    """What the step gives, over sigma, a and E of the scene."""
    sigma, a, modulus = STRESS * stress, 5e-3 * size, YOUNG * young
    u, tips, contact, energy = sigma * a / modulus, result.tips, result.contact, result.energy
    return {
        "K": np.array([(tip.K_I, tip.K_II, tip.K_I_faces, tip.K_II_faces) for tip in tips]) / (sigma * np.sqrt(a)),
        "spread": np.array([(1.0, tip.K_I_spread / (sigma * np.sqrt(a))) for tip in tips]),
        "radius": np.array([tip.K_radius for tip in tips]) / a,
        "tip stress": np.array([(tip.sigma_1, tip.sigma_3) for tip in tips]) / sigma,
        "criticality": np.array([tip.criticality for tip in tips]),
        "tractions": np.stack([contact.normal_traction, contact.tangential_traction]) / sigma,
        "jumps": np.stack([contact.opening, contact.slip]) / u,
        "displacement": np.array([result.load_displacement]) / u,
        "energy": np.array([energy.work, energy.strain, energy.dissipated]) / (u * sigma * a),
        "path": np.concatenate([crack.points for crack in result.cracks]) / a,
        "load factor": np.array([result.load_factor]),
        "toughness": np.array([tip.K_growth for tip in tips]) / (sigma * np.sqrt(a)),
    }


def of_any_units(warnings: tuple[str, ...]) -> list[str]:
    """Leave out what is said of strains: sigma / E is the one number that these scales change."""
    return [text for text in warnings if "small strains and rotations are assumed" not in text]


@pytest.fixture(scope="module")
def plain(tmp_path_factory: pytest.TempPathFactory) -> Callable[[str], list[StepResult]]:
    """What solves the flaw in its own units."""
    return cache(lambda name: steps(tmp_path_factory.mktemp("plain"), SCENES[name], 1.0, 1.0, 1.0))


@pytest.mark.parametrize(
    ("name", "factors"),
    [
        *(pytest.param("friction", factors, id=f"friction, {extreme}") for extreme, factors in EXTREMES.items()),
        *(pytest.param(n, f, id=f"{n}, {e}", marks=pytest.mark.slow) for n in SCENES for e, f in TOGETHER.items()),
    ],
)
def test_growth_over_its_units_is_the_same(
    plain: Callable[[str], list[StepResult]], name: str, factors: tuple[float, float, float], tmp_path: Path
) -> None:
    found, expected = steps(tmp_path, SCENES[name], *factors), plain(name)
    assert len(found) == len(expected) == 3
    for there, here in zip(found, expected, strict=True):
        quantities = over_units(here, 1.0, 1.0, 1.0)
        for quantity, value in over_units(there, *factors).items():
            size = np.abs(quantities[quantity]).max()
            np.testing.assert_allclose(value, quantities[quantity], rtol=0.0, atol=SAME * size, err_msg=quantity)
        np.testing.assert_array_equal(there.contact.state, here.contact.state)
        assert [tip.kink_deg for tip in there.tips] == pytest.approx([tip.kink_deg for tip in here.tips], abs=KINK)
        assert [(tip.criterion, tip.advanced) for tip in there.tips] == [(t.criterion, t.advanced) for t in here.tips]
        assert len(of_any_units(there.warnings)) == len(of_any_units(here.warnings))


@pytest.mark.parametrize(
    ("name", "setting"),
    [
        ("block_foundation", "numerics.spacing=0.4"),
        ("interface_friction04", "numerics.spacing=0.1"),
        ("cyclic_friction", "loading.history=[1, 0.5, -0.3]"),
        ("junction_static", "numerics.support=2"),
    ],
)
@pytest.mark.parametrize("factors", TOGETHER.values(), ids=TOGETHER)
def test_other_scenes_over_their_units_are_the_same(
    name: str, setting: str, factors: tuple[float, float, float]
) -> None:
    """Bodies held by contact alone, prescribed displacements by formula, a load history, branches."""
    young, size, stress = factors
    case = load_case(CASES / f"{name}.yaml", [setting])
    placement = scaled(size, stress, young)
    assert everything(solved(placed(case, placement), placement), solved(case)) < SAME
