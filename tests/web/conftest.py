"""Fixtures of the web page."""

from browser_fixtures import browser

__all__ = ["browser"]
