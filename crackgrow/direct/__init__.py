"""The direct solver: sparse symmetric matrices, nested dissection, the multifrontal method; no mechanics.

What is named here is its door, all that other packages use of it.
"""

from crackgrow.direct.assembly import HalfMatrix, half, mirrored
from crackgrow.direct.dissection import Places
from crackgrow.direct.factorization import Factorization, factorize
from crackgrow.direct.matrix import EqualElements, SymmetricMatrix, blocks_of, symmetric
from crackgrow.direct.multifrontal import NOTHING, Kept

__all__ = [
    "NOTHING",
    "EqualElements",
    "Factorization",
    "HalfMatrix",
    "Kept",
    "Places",
    "SymmetricMatrix",
    "blocks_of",
    "factorize",
    "half",
    "mirrored",
    "symmetric",
]
