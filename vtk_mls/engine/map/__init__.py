"""The map on a device: nodes, cuts and the inverse."""
