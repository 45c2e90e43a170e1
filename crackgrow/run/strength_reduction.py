"""The factor of safety: the strength of contact divided by a factor until nothing holds the scene any more.

tan(phi), c and T of every surface, residual values and the tangent of the dilation angle included, are divided by the
same factor (Zienkiewicz, Humpheson, Lewis 1975). Every factor is a fresh start: the loads come on with the strength
that is left. The scene holds where contact and rock find a balance; where they don't, the limit analysis of the pieces
that contact alone holds says which of them moves, and how.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from crackgrow.case.model import CoulombContact
from crackgrow.errors import FreePieceError, NotSolvedError, SolveError
from crackgrow.fracture.advance import GrowingCrack
from crackgrow.run.configuration import Configuration, LoadLevel, assemble
from crackgrow.run.evaluation import StepSolution, evaluated
from crackgrow.run.increments import LoadState, held_loads, increment
from crackgrow.run.result import FARTHEST, Safety
from crackgrow.run.scene import Scene

NARROW = 1e-4
"""The factor of safety is found to this fraction."""

BEYOND = (1.0 + 1e-3, 1.01, 1.1)
"""Times the least factor without a state, at which a mechanism is looked for where none shows there, or a state."""

PROGRESSIVE = (
    "{}. With all points at full strength at once, as limit equilibrium has it, it would hold up to {:.5g}: strength "
    "that is lost is lost where stress is largest first. Where it is lost at once that depends on stiffness and on the "
    "size of cells; a `weakening_length` makes it a property of the contact, `cohesion_after_slip: kept` keeps cohesion"
)

MOST_RETURNS = 3
"""States beyond a factor at which none was found, after which that is how it is."""

UNNAMED = "{}. Limit analysis, for which faces that slide part as well, has it hold up to {:.5g}: there {}"


def strength_reduction(scene: Scene, cracks: tuple[GrowingCrack, ...]) -> tuple[Safety, Iterator[StepSolution]]:
    """How safe a scene is; it as it is, if it holds, and its last stable state. Raises SolveError if none holds."""
    given = assemble(scene, cracks)
    search = _Search(given)
    found = search.found()
    safety = _beside_limit_equilibrium(given, found, PROGRESSIVE if search.named else UNNAMED)
    states = dict.fromkeys(state for state in (search.as_given, search.last) if state is not None)
    return safety, map(evaluated, states)


class _Search:
    """The search for the largest factor that has a state."""

    def __init__(self, given: Configuration) -> None:
        self._given = given
        self._why: SolveError | None = None  # there is none at `_above`
        self._below, self._above = 0.0, np.inf
        self.as_given: LoadState | None = None
        self.last: LoadState | None = None  # of the largest factor that has one

    def found(self) -> Safety:
        """How safe the scene is. Raises SolveError where no factor has a state."""
        factor = 1.0
        if self._holds(factor):
            self.as_given = self.last
            while self._holds(factor := 2.0 * factor):
                if factor >= FARTHEST:
                    return Safety(np.inf, np.inf, "")
        else:
            while not self._holds(factor := 0.5 * factor):
                if factor <= 1.0 / FARTHEST:
                    assert self._why is not None
                    raise self._why
        self._narrow()
        returns = 0
        while not self.named and returns < MOST_RETURNS and self._holds_beyond():
            self._narrow()
            returns += 1
        what = self._why.what if isinstance(self._why, FreePieceError) else f"no state was found: {self._why}"
        return Safety(self._below, self._above, what)

    @property
    def named(self) -> bool:
        """Whether it is known what moves where there is no state."""
        return isinstance(self._why, FreePieceError)

    def _narrow(self) -> None:
        while self._above > (1.0 + NARROW) * self._below:
            self._holds(float(np.sqrt(self._below * self._above)))

    def _holds_beyond(self) -> bool:
        """Whether there is a state beyond the least factor at which none was found; else a mechanism is looked for."""
        above, why = self._above, self._why
        for times in BEYOND:
            self._above = np.inf
            if self._holds(times * above):
                self._above, self._why = 2.0 * times * above, why
                while self._holds(self._above):
                    self._above *= 2.0
                return True
            self._above = above
            if isinstance(self._why, FreePieceError):
                return False
        self._why = why
        return False

    def _holds(self, factor: float) -> bool:
        """Whether there is a state at a factor; the interval ends there."""
        configuration = _reduced(self._given, factor)
        try:
            configuration.check_can_hold(LoadLevel(1.0))  # sees at once what solvers look for in vain for long
            self.last, self._below = increment(configuration, held_loads(configuration), 1.0), factor
        except (FreePieceError, NotSolvedError) as error:
            self._above, self._why = factor, error
            return False
        return True


def _reduced(given: Configuration, factor: float) -> Configuration:
    """The scene with its strength divided by a factor."""
    if factor == 1.0:
        return given
    laws = tuple(
        law if law.contact is None else replace(law, contact=_weaker(law.contact, factor)) for law in given.scene.laws
    )
    return given.under_laws(laws)


def _beside_limit_equilibrium(given: Configuration, safety: Safety, words: str) -> Safety:
    """The same with what limit equilibrium says, in `words`, where contact could hold more with all of its strength."""
    below, above, way = safety.fails_at, np.inf, ""
    if given.contact.loose is None or not np.isfinite(below):
        return safety
    try:
        if _giving_way(given, below):
            return safety
        while above > (1.0 + NARROW) * below and below < FARTHEST:
            factor = float(np.sqrt(below * above)) if np.isfinite(above) else 2.0 * below
            gives = _giving_way(given, factor)
            below, above, way = (below, factor, gives) if gives else (factor, above, way)
    except NotSolvedError:
        return safety  # the factor is known without
    return replace(safety, mechanism=words.format(safety.mechanism, below, way)) if way else safety


def _giving_way(given: Configuration, factor: float) -> str:
    """Which piece moves where full strength over a factor can't hold it, and how; or empty. Raises NotSolvedError."""
    try:
        _reduced(given, factor).check_can_hold(LoadLevel(1.0))
    except FreePieceError as error:
        return error.what
    return ""


def _weaker(contact: CoulombContact, factor: float) -> CoulombContact:
    """A law with its strength divided by a factor."""
    wear = contact.wear
    return replace(
        contact,
        friction=contact.friction / factor,
        cohesion=contact.cohesion / factor,
        tension=contact.tension / max(factor, 1.0),  # the apex, cohesion over friction, stays where it is
        residual_friction=contact.residual_friction / factor,
        dilation_angle=_flatter(contact.dilation_angle, factor),
        residual_dilation_angle=_flatter(contact.worn[1], factor),
        wear=wear
        and replace(
            wear,
            friction=tuple(friction / factor for friction in wear.friction),
            dilation_angle=wear.dilation_angle and tuple(_flatter(angle, factor) for angle in wear.dilation_angle),
        ),
    )


def _flatter(angle: float, factor: float) -> float:
    """The angle (degrees) whose tangent is divided by a factor."""
    return float(np.rad2deg(np.arctan(np.tan(np.deg2rad(angle)) / factor)))
