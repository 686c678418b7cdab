"""What `vtk-mls demo` makes."""
