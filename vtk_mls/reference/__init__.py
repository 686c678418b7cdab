"""The specification in float64 numpy, as an engine."""
