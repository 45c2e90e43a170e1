"""The direct solver: sparse symmetric matrices, nested dissection, the multifrontal method; no mechanics."""
