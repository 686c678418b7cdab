"""Questions about a deformation that any engine can answer."""
