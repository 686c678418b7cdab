"""Must fail: an exception."""

raise SystemExit(1)
