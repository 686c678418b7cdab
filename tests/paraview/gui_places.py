"""Screen positions of widgets, inside ParaView's GUI; None while a widget is not visible.

ParaView has no Qt for Python; the system's package uses the Qt that runs in the process.
"""

from importlib import import_module

with open("/proc/self/maps") as _maps:  # which version of Qt runs
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
    found = _labeled(QtWidgets.QPushButton, text)
    return _middle(found, found.rect()) if found else None


def no_button(text):
    return not _labeled(QtWidgets.QPushButton, text)


def check_box(text):
    """A check box, by its label."""
    found = _labeled(QtWidgets.QCheckBox, text)
    if not found:
        return None
    place = found.rect()
    place.setWidth(20)
    return _middle(found, place)


def drop_down(name):
    """The drop-down list of a property or in a tool bar, by the name of its widget."""
    return _enabled(_drop_down(name))


def option(name, text):
    """An option of an open drop-down list."""
    found = _drop_down(name)
    if not found or not found.view().isVisible():
        return None
    view = found.view()
    return _middle(view.viewport(), view.visualRect(view.model().index(found.findText(text), 0)))


def tool(name):
    """A button with an icon, by the name of its widget or its action."""
    return _enabled(_tool(name))


def field(name):
    """The first text field of a property."""
    return _enabled(_field(name))


def tree():
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
    """The middle cell of the table in a widget."""
    return _enabled(_table(name))


def properties_beside(name):
    """The names of the visible properties in the part of the panel with a visible property."""
    panel = next(w for w in _visible(QtWidgets.QWidget) if w.objectName() == name).parentWidget()
    shown = [widget for widget in panel.children() if widget.inherits("pqPropertyWidget")]
    return sorted(widget.objectName() for widget in shown if widget.isVisible())


def widen(name, width):
    """Set the width of a dock."""
    (dock,) = (dock for dock in _visible(QtWidgets.QDockWidget) if dock.objectName() == name)
    horizontal = import_module(f"PyQt{_version}.QtCore").Qt.Orientation.Horizontal
    dock.window().resizeDocks([dock], [width], horizontal)


def hide_tool_bars_except(name):
    for bar in _visible(QtWidgets.QToolBar):
        bar.setVisible(bar.objectName() == name)


def to_scroll(kind, name):
    """Position for the mouse wheel, its button and the scroll bar's value, to make it visible."""
    found = {"drop_down": _drop_down, "tool": _tool, "field": _field, "table": _table}[kind](name)
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
    for tool in _visible(QtWidgets.QAbstractButton):
        action = tool.defaultAction() if isinstance(tool, QtWidgets.QToolButton) else None
        if name in (tool.objectName(), action and action.objectName()):
            return tool
    return None


def _part(name, kind):
    """The first visible widget of a class with this name or in a widget with this name."""
    for widget in _visible(QtWidgets.QWidget):
        if widget.objectName() == name:
            for found in [widget] if isinstance(widget, kind) else widget.findChildren(kind):
                if found.isVisible():
                    return found
    return None


def _visible(*classes):
    widgets = QtWidgets.QApplication.allWidgets()
    return [widget for widget in widgets if isinstance(widget, classes) and widget.isVisible()]


def _labeled(kind, text):
    buttons = _visible(kind)
    return next((b for b in buttons if _plain(b.text()) == text and b.isEnabled()), None)


def _enabled(widget):
    return _middle(widget, widget.rect()) if widget and widget.isEnabled() else None


def _plain(text):
    """A label without its shortcuts."""
    return text.replace("&", "").partition("\t")[0].rstrip(". ")


def _middle(widget, rectangle):
    """The middle of a part of a widget; None while it is covered."""
    middle = rectangle.center()
    if not widget.visibleRegion().contains(middle):
        return None
    place = widget.mapToGlobal(middle)
    return [place.x(), place.y()]
