"""The value of a deformation: control points, regions, options."""
