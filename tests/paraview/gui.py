"""ParaView's GUI under Xvfb, with hands and eyes: real keys and mouse events, screenshots."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import time
from contextlib import contextmanager, suppress

LISTENER = "tests/paraview/gui_listener.py"
PLAIN = ("paraview", "--dr", f"--script={LISTENER}")
PATIENCE = 180  # seconds, for whatever is waited for
WHEEL_DOWN = 5  # a mouse button
WIDTH, HEIGHT = 1280, 1024


class Gui:
    """A running ParaView.

    Parameters
    ----------
    folder : Path, relative to the project
        For the talk with the listener inside, and screenshots.
    project : Path
    display : str
        X display.
    process : Popen
    """

    def __init__(self, folder, project, display, process):
        self._folder, self.folder = project / folder, folder
        self._display, self._process = display, process
        self.clicks = 0  # so far, drags included

    def run(self, text):
        """Run Python inside; the value that it gives to `answer`."""
        part, reply = self._folder / "request.part", self._folder / "reply.json"
        part.write_text(text)
        part.rename(self._folder / "request.py")
        self._wait(reply.exists, f"an answer to: {text}")
        answer = json.loads(reply.read_text())
        reply.unlink()
        assert "error" not in answer, answer["error"]
        return answer["answer"]

    def value(self, expression):
        """The value of a Python expression inside."""
        return self.run(f"answer = {expression}")

    def until(self, expression):
        """Wait until a Python expression inside is true."""
        self._wait(lambda: self.value(f"bool({expression})"), expression)

    def press(self, *keys):
        """Press keys in the main window, one after the other."""
        self._xdotool("windowfocus", "--sync", self._window)
        self._xdotool("key", "--delay", 50, *keys)

    def end(self):
        """Leave ParaView as a user does, who wants his settings kept."""
        self.press("ctrl+q")
        self._process.wait(PATIENCE)

    def launch(self, name):
        """Create a source or filter by the quick-launch dialog, as from the menu."""
        active = "getattr(simple.GetActiveSource(), 'GetGlobalID', int)()"
        before = self.value(active)
        known = set(self._windows())
        self.press("ctrl+space")
        self._wait(lambda: set(self._windows()) - known, "the quick-launch dialog")
        # without a window manager nobody else gives it the keyboard in time
        self._xdotool("windowfocus", "--sync", *set(self._windows()) - known)
        self._xdotool("type", "--delay", 50, name)
        self._xdotool("key", "--delay", 100, "Return")
        self.until(f"{active} != {before}")

    def click(self, place):
        """Click on what `gui_places` finds, as soon as it is there."""
        self.hover(place)
        self._xdotool("click", 1)
        self.clicks += 1

    def hover(self, place):
        """Point at what `gui_places` finds, as soon as it is there."""
        found = []

        def is_still():  # windows move as they open
            found.append(self._place(place))
            return found[-1] and found[-2:] == [found[-1]] * 2

        self._wait(is_still, place)
        x, y = found[-1]
        for shift in (5, 0):  # a menu that opens under the mouse takes the second motion for one
            self._xdotool("mousemove", "--sync", x + shift, y)

    def scroll_to(self, what, name):
        """Turn the mouse wheel until what `gui_places` calls `what` can be seen."""
        turn, seen = f"to_scroll({what!r}, {name!r})", f"{what}({name!r})"
        self._wait(lambda: self._place(turn) or self._place(seen), seen)
        while before := self._place(turn):
            x, y, direction, _ = before
            self._xdotool("mousemove", x, y)  # it may be there already, then --sync would wait
            self._xdotool("click", direction)
            self._wait(lambda: self._place(turn) != before, "the panel to scroll")

    def find_and_click(self, what, name):
        """Click on it, after scrolling if need be."""
        self.scroll_to(what, name)
        self.click(f"{what}({name!r})")

    def find_in_tree(self, row, column=0, clicks=1):
        """Click on the cell that `gui_places.tree_cell` finds below, once or twice."""
        self.hover("tree()")
        place = f"tree_cell({row!r}, {column})"
        for _ in range(20):
            if not self._place(place):
                self._xdotool("click", WHEEL_DOWN)
        self.hover(place)
        self._xdotool("click", "--repeat", clicks, 1)

    def type(self, text):
        """Type text and Return into what has the focus."""
        self._xdotool("type", "--delay", 20, text)
        self._xdotool("key", "--delay", 100, "Return")

    def enter(self, text, place):
        """Type text and Return, until what `gui_places` finds is there.

        A list of completions that opens late takes a Return for itself.
        """
        self.type(text)
        last, tries = time.monotonic(), 0

        def is_there():
            nonlocal last, tries
            if self._place(place):
                return True
            if time.monotonic() - last > 5:
                tries += 1
                if tries % 3 == 0:  # letters may be lost, too
                    self._xdotool("key", "ctrl+a")
                    self._xdotool("type", "--delay", 50, text)
                self._xdotool("key", "Return")
                last = time.monotonic()
            return False

        self._wait(is_there, place)

    @contextmanager
    def dragging(self, place, by, key=None):
        """Take hold of what is at a place in the world, and pull it by so many pixels.

        The key, if there is one, is held meanwhile.
        """
        x, y = self._on_screen(place)
        self.clicks += 1
        self._xdotool("mousemove", "--sync", x, y)
        if key:
            self._xdotool("keydown", key)
        self._xdotool("mousedown", 1)
        for step in range(1, 11):
            self._xdotool("mousemove", "--sync", x + step * by[0] // 10, y - step * by[1] // 10)
        try:
            yield
        finally:  # tests share a display
            self._xdotool("mouseup", 1)
            if key:
                self._xdotool("keyup", key)

    def click_at(self, place, key):
        """Click on what is at a place in the world, while a key is held."""
        x, y = self._on_screen(place)
        self._xdotool("mousemove", "--sync", x, y)
        self._xdotool("keydown", key)
        self._xdotool("click", 1)
        self._xdotool("keyup", key)
        self.clicks += 1

    def windows(self):
        """Ids of its windows that are visible."""
        return self._windows()

    def move(self, by):
        """Move the mouse by so many pixels."""
        self._xdotool("mousemove_relative", "--sync", "--", by[0], -by[1])

    def shake(self, seconds, rate=100):
        """Move the mouse to and fro by a pixel or two, so many times a second at most."""
        moves = [(2, 1), (-1, -2), (1, 2), (-2, -1)]
        steps = [moves[number % 4] for number in range(int(rate * seconds))]
        for part in (steps[at : at + rate // 2] for at in range(0, len(steps), rate // 2)):
            chain = (("mousemove_relative", "--", *step, "sleep", 1 / rate) for step in part)
            self._xdotool(*(each for link in chain for each in link))

    def shake_until(self, expression):
        """Move the mouse to and fro until a Python expression inside is true."""

        def is_true():
            self.shake(2)
            return self.value(f"bool({expression})")

        self._wait(is_true, expression)

    def screenshot(self, name):
        """Keep what is on the screen; the file."""
        path = self._folder / f"{name}.png"
        command = ["import", "-window", "root", str(path)]
        subprocess.run(command, env=self._environment, check=True, timeout=PATIENCE)
        return path

    @property
    def pointer(self):
        """Where the mouse is on the screen."""
        found = self._xdotool("getmouselocation", "--shell").splitlines()
        return tuple(int(line.partition("=")[2]) for line in found[:2])

    @property
    def printed(self):
        """All it has printed, which is also what Output Messages show."""
        return (self._folder / "log.txt").read_text()

    def spread(self):
        """Wait for the main window, and give it the whole screen."""
        self._wait(self._windows, "a window")
        (self._window,) = self._windows()
        self._xdotool("windowmove", self._window, 0, 0)
        self._xdotool("windowsize", "--sync", self._window, WIDTH, HEIGHT)

    def _place(self, place):
        return self.run(f"import gui_places; answer = gui_places.{place}")

    def _on_screen(self, place):
        """Where on the screen a place in the world is."""
        middle = WIDTH * 2 // 3, HEIGHT // 2
        for shift in (5, 0):  # an event needs a motion
            self._xdotool("mousemove", "--sync", middle[0] + shift, middle[1])
        mouse = "view.GetInteractor()"
        self.until(f"0 < {mouse}.GetEventPosition()[0] < {mouse}.GetSize()[0]")
        seen = self.value(f"list({mouse}.GetEventPosition())")
        x, y = self.run(f"""
from vtkmodules.vtkRenderingCore import vtkCoordinate
coordinate = vtkCoordinate()
coordinate.SetCoordinateSystemToWorld()
coordinate.SetValue({place[0]}, {place[1]}, {place[2]})
answer = list(coordinate.GetComputedDisplayValue(view.GetRenderer()))""")
        return middle[0] + x - seen[0], middle[1] - y + seen[1]

    def _windows(self):
        found = self._xdotool("search", "--onlyvisible", "--class", "paraview", check=False)
        return found.split()

    @property
    def _environment(self):
        return {**os.environ, "DISPLAY": self._display}

    def _xdotool(self, *arguments, check=True):
        done = subprocess.run(
            ["xdotool", *map(str, arguments)],
            env=self._environment,
            stdout=subprocess.PIPE,
            text=True,
            check=check,
            timeout=PATIENCE,
        )
        return done.stdout

    def _wait(self, condition, what):
        end = time.monotonic() + PATIENCE
        while not condition():
            assert self._process.poll() is None, f"ParaView has ended:\n{self.printed}"
            assert time.monotonic() < end, f"waited in vain for {what}\n{self.printed}"
            time.sleep(0.02)


@contextmanager
def running(paraview, project, folder, display, command=PLAIN, **variables):
    """A ParaView with a `Gui`, ended at the end.

    Parameters
    ----------
    paraview : paraviews.ParaView
    project : Path
    folder : Path, relative to the project
    display : str
    command : sequence of str, optional
        Starts it.
    **variables : str
        Of its environment.
    """
    (project / folder).mkdir(parents=True, exist_ok=True)
    for name in ("request.py", "reply.json"):
        (project / folder / name).unlink(missing_ok=True)
    environment = paraview.environment(
        DISPLAY=display,
        QT_QPA_PLATFORM="xcb",
        PARAVIEW_GUI_FOLDER=str(folder),
        MESA_SHADER_CACHE_DISABLE="true",  # a shader from there is not warned of again
        **variables,
    )
    environment.pop("VTK_DEFAULT_OPENGL_WINDOW", None)
    with (project / folder / "log.txt").open("w") as log:
        process = subprocess.Popen(
            [*paraview.prefix, *command],
            cwd=project,
            env=environment,
            stdin=subprocess.DEVNULL,
            stdout=log,
            stderr=subprocess.STDOUT,
            start_new_session=True,
        )
        try:
            gui = Gui(folder, project, display, process)
            gui.value("1")
            gui.spread()
            yield gui
        finally:
            with suppress(ProcessLookupError):
                os.killpg(process.pid, signal.SIGKILL)
            process.wait()
