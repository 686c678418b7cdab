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


def check_box(text):
    """A check box, by its label."""
    for each in _visible(QtWidgets.QCheckBox):
        if _plain(each.text()) == text and each.isEnabled():
            place = each.rect()
            place.setWidth(20)
            return _middle(each, place)
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


def tool(name):
    """A button with a picture, by the name of its widget."""
    found = _tool(name)
    return _middle(found, found.rect()) if found and found.isEnabled() else None


def field(name):
    """The first line to type into of a property."""
    found = _field(name)
    return _middle(found, found.rect()) if found and found.isEnabled() else None


def tree():
    """The tree of a dialog."""
    found = _visible(QtWidgets.QTreeWidget)
    return _middle(found[0].viewport(), found[0].viewport().rect()) if found else None


def tree_cell(row, column):
    """The left end of a cell of a tree, where its check box is, by the text that begins its row."""
    for tree in _visible(QtWidgets.QTreeWidget):
        items = QtWidgets.QTreeWidgetItemIterator(tree)
        while item := items.value():
            place = tree.visualItemRect(item)
            if item.text(0) == row and not place.isEmpty():
                place.setX(max(place.x(), tree.columnViewportPosition(column)))
                place.setWidth(20)
                return _middle(tree.viewport(), place)
            items += 1
    return None


def table(name):
    """The cell in the middle of the table in a widget."""
    found = _table(name)
    return _middle(found, found.rect()) if found else None


def widen(name, width):
    """Make a dock so wide that all of its panel is in sight."""
    (dock,) = (each for each in _visible(QtWidgets.QDockWidget) if each.objectName() == name)
    horizontal = import_module(f"PyQt{_version}.QtCore").Qt.Orientation.Horizontal
    dock.window().resizeDocks([dock], [width], horizontal)


def to_scroll(what, name):
    """Where to turn the mouse wheel which way, for one of the above to come into sight."""
    found = {"drop_down": _drop_down, "tool": _tool, "field": _field, "table": _table}[what](name)
    if not found or _middle(found, found.rect()):
        return None
    area = found
    while not isinstance(area, QtWidgets.QScrollArea):
        area = area.parentWidget()
    bar = area.verticalScrollBar()
    is_below = found.mapTo(area, found.rect().center()).y() > area.height() // 2
    return [*_middle(bar, bar.rect()), WHEEL_DOWN if is_below else WHEEL_UP, bar.value()]


def _drop_down(name):
    return _part(name, QtWidgets.QComboBox)


def _field(name):
    return _part(name, QtWidgets.QLineEdit)


def _table(name):
    found = _part(name, QtWidgets.QTableView)
    return found and found.viewport()  # which hides the table itself


def _tool(name):
    tools = _visible(QtWidgets.QToolButton)
    return next((each for each in tools if each.objectName() == name), None)


def _part(name, kind):
    """The first visible widget of a kind that has a name or is in a widget that has."""
    for widget in _visible(QtWidgets.QWidget):
        if widget.objectName() == name:
            for found in [widget] if isinstance(widget, kind) else widget.findChildren(kind):
                if found.isVisible():
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
