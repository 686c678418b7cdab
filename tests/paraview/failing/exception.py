"""Must be seen to fail: an exception."""

raise SystemExit(1)
