"""A case as YAML text that reads back to the same case, bit for bit."""

from __future__ import annotations

import yaml

from crackgrow.case.model import Case


class _Dumper(yaml.SafeDumper):
    """Writes equal lists out instead of naming them once and pointing to them."""

    def ignore_aliases(self, data: object) -> bool:
        return True


def dump_case(case: Case) -> str:
    """Return the resolved case as YAML: SI units, every default filled in, floats with all their digits."""
    return yaml.dump(
        case.resolved, Dumper=_Dumper, sort_keys=False, allow_unicode=True, default_flow_style=None, width=100
    )
