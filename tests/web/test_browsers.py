"""The browser that opens the page, and the sentence without the packages of the page."""

from __future__ import annotations

import sys

import pytest

from vtk_mls.commands.cli import main
from vtk_mls.web import browsers

_ADDRESS = "http://127.0.0.1:1/?token=x"


@pytest.fixture
def opened(tmp_path, monkeypatch):
    """Addresses that the default browser opens; commands are only those in tmp_path."""
    addresses = []
    monkeypatch.setattr(browsers.webbrowser, "open", addresses.append)
    monkeypatch.setattr(sys, "platform", "linux")
    monkeypatch.setenv("PATH", str(tmp_path))
    monkeypatch.setenv("DISPLAY", ":1")
    return addresses


def _write_command(path, lines):
    path.write_text(f"#!/bin/sh\n{lines}\n")
    path.chmod(0o755)


def test_chromium_opens_a_window_of_its_own(opened, tmp_path):
    _write_command(tmp_path / "chromium", f'echo "$@" > {tmp_path}/arguments')
    browsers.open_page(_ADDRESS)
    assert (tmp_path / "arguments").read_text() == f"--app={_ADDRESS}\n"
    assert opened == []


def test_the_default_browser_opens_the_page_if_there_is_no_other_or_it_fails(opened, tmp_path):
    browsers.open_page(_ADDRESS)
    _write_command(tmp_path / "chromium", "exit 1")
    browsers.open_page(_ADDRESS)
    assert opened == [_ADDRESS] * 2


def test_nothing_opens_without_a_display(opened, monkeypatch):
    for name in ("DISPLAY", "WAYLAND_DISPLAY"):
        monkeypatch.delenv(name, raising=False)
    browsers.open_page(_ADDRESS)
    assert opened == []


def test_missing_packages_of_the_page_are_named(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "ball.vtk").write_text(
        "# vtk DataFile Version 3.0\nx\nASCII\nDATASET POLYDATA\nPOINTS 3 float\n"
        "0 0 0 1 0 0 0 1 0\nPOLYGONS 1 4\n3 0 1 2\n"
    )
    monkeypatch.setitem(sys.modules, "trame.app", None)
    monkeypatch.delitem(sys.modules, "vtk_mls.web.server", raising=False)
    assert main(["view", "ball.vtk"]) == 1
    assert capsys.readouterr().err == (
        "vtk-mls: the page needs trame, which is not installed: pip install trame trame-vuetify; "
        "or `--window` opens a plain window\n"
    )
