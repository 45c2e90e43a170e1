"""Poisson's ratio, and bodies of very unlike stiffness."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import product

from crackgrow.case.checks import LARGEST_POISSON
from tests.stability.extremes.measures import contact_tractions
from tests.stability.extremes.scenes import FOUNDATION, RIGID, Scenes
from tests.stability.extremes.trial import Trial
from tests.stability.solved import against, balanced, stress_intensity

K_TOLERANCE = 1e-2

BLOCK = 1e3
"""Pa: Young's modulus of the block on the foundation."""

BALANCE = 1e-9
"""What may be missing of the equilibrium of forces and of the energy balance."""

LIKE_RIGID, LIKE_SOFT = 1e3, 1e-3
"""Ratios of the moduli from which on tractions are those of a limit, but for a part of the size of the ratio."""

SOFT = 1e-6
"""Ratio that stands for the soft limit."""

NEARNESS = 3.0
"""Tractions differ from those of the limit by at most so many times the ratio (measured: 0.2 and 1.5)."""


def poisson(scenes: Scenes) -> Iterator[Trial]:
    """Tractions alone load the specimen: its stress and K do not depend on the elastic constants (Michell 1899)."""
    values = {"strain": (0.0, 0.4, 0.49, 0.499, 0.4999, 0.49999, 0.5), "stress": (0.0, 0.4, 0.49, 0.499, 0.5)}
    if scenes.short:
        values = {"strain": (0.0, 0.49, 0.499, 0.49999), "stress": (0.5,)}
    for plane, ratios in values.items():
        for ratio in ratios:
            settings = (f"plane={plane}", _ratio(ratio))
            beyond = plane == "strain" and ratio > LARGEST_POISSON
            yield _poisson(scenes, "poisson", f"{ratio:g}, plane {plane}", settings, (), beyond)


def poisson_and_stiffness(scenes: Scenes) -> Iterator[Trial]:
    """Both at once."""
    for ratio, kappa in product((0.49, 0.4999), scenes.few((1e4, 1e12), (1e12,))):
        elastic = (f"numerics.contact.stiffness={kappa!r}",)
        value = f"{ratio:g}, {kappa:g} E/h"
        yield _poisson(scenes, "poisson x stiffness", value, (_ratio(ratio), *elastic), elastic)


def contrast(scenes: Scenes) -> Iterator[Trial]:
    """A block on a foundation, held by contact alone: as on a rigid one, or as a rigid one, in the limits."""
    ratios = scenes.few((1e-9, 1e-6, 1e-3, 1.0, 1e3, 1e6, 1e7, 1e9), (1e-6, 1.0, 1e7))
    for ratio in ratios:
        name, settings = f"{ratio:g}", (_foundation(ratio),)
        usual = scenes.usual_case(FOUNDATION)
        solve = scenes.solved_case(FOUNDATION, *settings)
        yield Trial("contrast", name, "forces, energy and residual in balance", BALANCE, solve, balanced, usual)
        if ratio >= LIKE_RIGID:
            limit, near, text = scenes.usual_case(RIGID), 1.0 / ratio, "tractions of the rigid foundation"
        elif ratio <= LIKE_SOFT and ratio != SOFT:
            limit, near = scenes.usual_case(FOUNDATION, _foundation(SOFT)), max(ratio, SOFT)
            text = f"tractions at {SOFT:g}"
        else:
            continue
        yield Trial(
            "contrast",
            name,
            text,
            NEARNESS * near + BALANCE,
            solve,
            against(limit, contact_tractions),
            usual,
        )


def _ratio(ratio: float) -> str:
    return f"bodies.rock.material.poisson={ratio!r}"


def _foundation(ratio: float) -> str:
    return f"bodies.foundation.material.young={ratio * BLOCK!r}"


def _poisson(
    scenes: Scenes, axis: str, value: str, settings: tuple[str, ...], usual: tuple[str, ...], refusable: bool = False
) -> Trial:
    plain = scenes.usual_flaw(*usual)
    return Trial(
        axis,
        value,
        "K at Poisson's ratio 0.25 (exact: the same)",
        K_TOLERANCE,
        scenes.solved_flaw(*settings),
        against(plain, stress_intensity),
        plain,
        refusable=refusable,
    )
