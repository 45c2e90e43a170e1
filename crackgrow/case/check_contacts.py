"""Whether the laws of contact are ones that rock can have: slip takes friction away and never makes energy."""

from __future__ import annotations

import math
from collections.abc import Iterator

from crackgrow.case.layout import Scene, named
from crackgrow.case.report import Path
from crackgrow.case.shapes import Resolved


def check_contacts(scene: Scene) -> None:
    """Report a residual friction above the friction, and a dilation steeper than the residual friction."""
    for key, law in contact_laws(scene):
        friction, residual, dilation = law["friction"], law["residual_friction"], law["dilation_angle"]
        if residual > friction:
            message = f"{residual:g} given; wanted: at most the friction, {friction:g}: slip wears faces, it cannot"
            scene.report.fault((*key, "residual_friction"), f"{message} make them rougher")
        elif math.tan(math.radians(dilation)) > residual:
            steepest = math.degrees(math.atan(residual))
            limit = f"at most {steepest:.4g} deg, whose tangent is the residual friction, {residual:g}"
            why = "faces that rise more steeply than friction holds them back would create energy when they slip"
            scene.report.fault((*key, "dilation_angle"), f"{dilation:g} deg given; wanted: {limit}: {why}")
        keeps = law["cohesion"] == 0.0 or law["cohesion_after_slip"] == "kept"
        if "weakening_length" in law and residual == friction and keeps:
            message = "nothing weakens: give a residual_friction below the friction, or a cohesion that slip takes"
            scene.report.fault((*key, "weakening_length"), message)


def contact_laws(scene: Scene) -> Iterator[tuple[Path, Resolved]]:
    """Yield every law that is given and sound, with its key."""
    for name in named(scene.resolved, "cracks"):
        law = scene.get("cracks", name, "contact")
        if isinstance(law, dict):
            yield ("cracks", name, "contact"), law
    for kind in ("interfaces", "supports"):
        for index, item in scene.items(kind, "contact"):
            if isinstance(item["contact"], dict):
                yield (kind, index, "contact"), item["contact"]
