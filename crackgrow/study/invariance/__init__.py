"""Whether a case gives the same in other units, on another lattice and in another place, as it must."""
