"""Commands of `vtk-mls`, a module each: `add(commands)` says its arguments."""
