"""The editor on a page: served by trame, drawn where the server runs."""
