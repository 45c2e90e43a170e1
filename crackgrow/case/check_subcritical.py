"""Whether tips can grow below their toughness as the case wants them to."""

from __future__ import annotations

from crackgrow.case.check_strength import strengths
from crackgrow.case.layout import Scene


def check_subcritical(scene: Scene) -> None:
    """The law has its constants and a toughness, under loads that are given; all tips go at once, and none starts."""
    law, report = scene.get("growth", "law"), scene.report
    given = scene.get("growth", "subcritical") is not None
    if law == "critical" and given:
        report.fault(("growth", "subcritical"), "is for law: subcritical; leave it out, or give `law: subcritical`")
    if law != "subcritical":
        return
    if not given and report.sound("growth", "subcritical"):
        message = "missing: {velocity: v_max, exponent: n} of v = v_max (K/K_c)^n, for law: subcritical"
        report.fault(("growth", "subcritical"), message)
    advance, at = scene.get("growth", "advance"), scene.get("growth", "initiation", "at")
    if advance not in (None, "all"):
        message = f"{advance} given; wanted with law: subcritical: all, since every tip has its velocity"
        report.fault(("growth", "advance"), message)
    if at not in (None, "tips"):
        message = f"{at} given; wanted with law: subcritical: tips. Cracks start where the criterion is met, at no time"
        report.fault(("growth", "initiation", "at"), message)
    if scene.get("loading") == "critical":
        message = "critical holds a tip at K = K_c, where it is unstable; wanted with growth.law: subcritical"
        report.fault(("loading",), f"{message}: a history of loads, or stages")
    without = strengths(scene, with_toughness=False) if report.sound("bodies") else []
    if without:
        message = f"subcritical needs K over K_c, and bodies.{without[0]}.strength has no toughness; give it one"
        report.fault(("growth", "law"), message)
