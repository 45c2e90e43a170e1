"""The approximation: weight, moving least squares, tip functions, and all basis functions at points."""
