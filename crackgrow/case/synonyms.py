"""What users of other programs and of books write, and the keys and words that it means here, for hints."""

from __future__ import annotations

from typing import Final

SYNONYMS: Final = {  # in small letters: the first of these that is allowed where it stands
    # elastic constants
    "e": ("young",), "modulus": ("young",), "youngs_modulus": ("young",), "elastic_modulus": ("young",),
    "nu": ("poisson",), "v": ("poisson",), "poissons_ratio": ("poisson",), "rho": ("density",),
    # strength and contact
    "sigma_t": ("tension",), "t0": ("tension",), "ft": ("tension",), "tensile": ("tension",),
    "tensile_strength": ("tension",), "jtension": ("tension",), "c": ("cohesion",),
    "c0": ("cohesion",), "phi": ("friction_angle", "friction"), "mu": ("friction",), "psi": ("dilation_angle",),
    "mu_r": ("residual_friction",), "kn": ("normal",), "ks": ("shear",), "kt": ("shear",), "dc": ("weakening_length",),
    "k_ic": ("toughness",), "kic": ("toughness",), "k_iic": ("shear_toughness",), "kiic": ("shear_toughness",),
    "frictionless": ("none",), "glued": ("bonded",),
    # shapes and places
    "circle": ("disk",), "box": ("rectangle",), "square": ("rectangle",), "r": ("radius",), "w": ("width",),
    "h": ("spacing", "height"), "dip": ("angle",), "theta": ("angle",), "vertices": ("points", "polygon"),
    "coordinates": ("points", "polygon"), "point": ("at",), "edge": ("on",), "side": ("edge", "on"), "where": ("on",),
    # the scene
    "name": ("title",), "blocks": ("bodies",), "joints": ("cracks",), "faults": ("cracks",), "flaws": ("cracks",),
    "boundary_conditions": ("supports",), "bcs": ("supports",), "u": ("displacement",), "fixed": ("displacement",),
    "t": ("traction",), "p": ("pressure",), "g": ("gravity",), "sigma": ("stress",), "f": ("force",),
    "stage": ("stages", "history"), "excavation": ("excavate",), "remove": ("excavate",), "phases": ("stages",),
    "mesh": ("numerics",), "mesh_size": ("spacing",), "da": ("increment",),
    "n_steps": ("steps",),
}  # fmt: skip

_UCS: Final = "a uniaxial compressive strength C gives cohesion = C (1 - sin phi) / (2 cos phi), phi: friction_angle"
_IN_SITU: Final = "stress from the start is a load: `loads: [{stress: [-12 MPa, -8 MPa, 0]}]`, [xx, yy, xy]"
_GRAVITY: Final = "weight is a load, and needs a `density`: `loads: [{gravity: [0, -9.81 m/s^2]}]`"
_PRESSURE: Final = "fluid pressure in a crack is a load: `loads: [{crack: NAME, pressure: 1 MPa}]`"
_EDGES: Final = "names of edges belong to the body, beside `shape`: `bodies: {NAME: {edges: {inlet: 3}}}`"
_FACTOR: Final = "loads have the factors of `loading`, such as {history: [0.5, 1]}; `held: true` keeps one as it is"

EXPLAINED: Final = {  # what no key stands for: a key that is allowed where it stands, and what to do instead
    "compression": ("friction_angle", _UCS), "compressive": ("friction_angle", _UCS),
    "compressive_strength": ("friction_angle", _UCS), "sigma_c": ("friction_angle", _UCS),
    "ucs": ("friction_angle", _UCS), "factor": ("held", _FACTOR), "load_factor": ("held", _FACTOR),
    "in_situ": ("loads", _IN_SITU), "insitu": ("loads", _IN_SITU), "in_situ_stress": ("loads", _IN_SITU),
    "initial_stress": ("loads", _IN_SITU), "prestress": ("loads", _IN_SITU), "stress": ("loads", _IN_SITU),
    "edges": ("polygon", _EDGES), "gravity": ("loads", _GRAVITY), "weight": ("loads", _GRAVITY),
    "pressure": ("tips", _PRESSURE), "fluid_pressure": ("tips", _PRESSURE), "p": ("tips", _PRESSURE),
}  # fmt: skip
