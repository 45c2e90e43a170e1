"""The direct solver: a sparse symmetric matrix, nested dissection, fronts, linear constraints; no mechanics.

What is named here is its door, all that other packages use of it.
"""

from crackgrow.linear.constrained import ConstrainedSystem
from crackgrow.linear.elimination import DEPENDENT, mirror
from crackgrow.linear.matrix import SymmetricMatrix

__all__ = ["DEPENDENT", "ConstrainedSystem", "SymmetricMatrix", "mirror"]
