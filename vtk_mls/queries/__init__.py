"""Questions about a deformation, answered through any engine."""
