"""Commands of `vtk-mls`, a module each: `add(commands)` for the arguments, `run(options)`."""
