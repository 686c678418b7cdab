"""Modules that need numpy at most, and that all others may use."""
