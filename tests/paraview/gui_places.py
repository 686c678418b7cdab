"""Where things are on the screen, asked inside ParaView's GUI: what a user sees and clicks.

ParaView brings no Qt for Python; the system's does, for it joins the Qt that runs in the process.
Places are screen coordinates, or None while a thing is not to be seen.
"""

from importlib import import_module

with open("/proc/self/maps") as _maps:  # two versions of Qt in a process do not see each other
    _version = 6 if "libQt6Widgets" in _maps.read() else 5
QtWidgets = import_module(f"PyQt{_version}.QtWidgets")

WHEEL_UP, WHEEL_DOWN = 4, 5  # mouse buttons


def menu_item(text):
    """An item of the menu bar, or of a menu that is open."""
    for menu in _visible(QtWidgets.QMenu, QtWidgets.QMenuBar):
        for action in menu.actions():
            if _plain(action.text()) == text:
                return _middle(menu, menu.actionGeometry(action))
    return None


def button(text):
    """A button that can be pressed, by its label."""
    for each in _visible(QtWidgets.QPushButton):
        if _plain(each.text()) == text and each.isEnabled():
            return _middle(each, each.rect())
    return None


def drop_down(name):
    """The drop-down list of a property, or in a tool bar, by the name of its widget."""
    found = _drop_down(name)
    return _middle(found, found.rect()) if found and found.isEnabled() else None


def option(name, text):
    """An option of such a list that is open."""
    found = _drop_down(name)
    if not found or not found.view().isVisible():
        return None
    view = found.view()
    return _middle(view.viewport(), view.visualRect(view.model().index(found.findText(text), 0)))


def to_scroll(name):
    """Where to turn the mouse wheel which way, for a drop-down list to come into sight."""
    found = _drop_down(name)
    if not found or _middle(found, found.rect()):
        return None
    area = found
    while not isinstance(area, QtWidgets.QScrollArea):
        area = area.parentWidget()
    bar = area.verticalScrollBar()
    is_below = found.mapTo(area, found.rect().center()).y() > area.height() // 2
    return [*_middle(bar, bar.rect()), WHEEL_DOWN if is_below else WHEEL_UP, bar.value()]


def _drop_down(name):
    for widget in _visible(QtWidgets.QWidget):
        if widget.objectName() == name:
            for found in widget.findChildren(QtWidgets.QComboBox):
                return found
    return None


def _visible(*classes):
    every = QtWidgets.QApplication.allWidgets()
    return [each for each in every if isinstance(each, classes) and each.isVisible()]


def _plain(text):
    """A label without the marks of its keys."""
    return text.replace("&", "").partition("\t")[0].rstrip(". ")


def _middle(widget, rectangle):
    """The middle of a part of a widget, if it is not scrolled out of sight."""
    middle = rectangle.center()
    if not widget.visibleRegion().contains(middle):
        return None
    place = widget.mapToGlobal(middle)
    return [place.x(), place.y()]
