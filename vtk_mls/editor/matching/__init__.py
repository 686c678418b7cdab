"""Landmarks on data and a target: pairs, both views, comparison, refinement."""
