"""The direct solver: sparse symmetric matrices, nested dissection, the multifrontal method; no mechanics.

What is named here is its door, all that other packages use of it.
"""

from crackgrow.direct.assembly import HalfMatrix, half, sum_of
from crackgrow.direct.dissection import Places
from crackgrow.direct.factorization import Factorization, factorize
from crackgrow.direct.matrix import EqualElements, SymmetricMatrix, symmetric
from crackgrow.direct.multifrontal import Factor

__all__ = [
    "EqualElements",
    "Factor",
    "Factorization",
    "HalfMatrix",
    "Places",
    "SymmetricMatrix",
    "factorize",
    "half",
    "sum_of",
    "symmetric",
]
