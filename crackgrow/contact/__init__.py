"""Contact of crack faces: contact points, the jump operator, the Coulomb law, the solvers of the condensed problem."""
