"""VTK data as numpy arrays, and mesh algorithms."""
