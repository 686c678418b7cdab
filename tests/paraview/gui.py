"""ParaView's GUI under Xvfb, driven by real keys and mouse events."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import time
from contextlib import contextmanager, suppress

LISTENER = "tests/paraview/gui_listener.py"
PLAIN = ("paraview", "--dr", f"--script={LISTENER}")
TIMEOUT = 180  # seconds
WHEEL_DOWN = 5  # a mouse button
WIDTH, HEIGHT = 1280, 1024


class Gui:
    """A running ParaView. Requests to the listener and screenshots are in a folder of `project`."""

    def __init__(self, folder, project, display, process):
        self._folder, self.folder = project / folder, folder
        self._display, self._process = display, process
        self.clicks = 0  # so far, drags included

    def run(self, text):
        """Run Python inside; returns the value of its variable `answer`."""
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
        """Quit ParaView as a user does, so that it saves its settings."""
        self.press("ctrl+q")
        self._process.wait(TIMEOUT)

    def launch(self, name):
        """Create a source or filter by the quick-launch dialog, as from the menu."""
        active = "getattr(simple.GetActiveSource(), 'GetGlobalID', int)()"
        before = self.value(active)
        windows = set(self.windows())
        self.press("ctrl+space")
        self._wait(lambda: set(self.windows()) - windows, "the quick-launch dialog")
        # there is no window manager to give it the keyboard
        self._xdotool("windowfocus", "--sync", *set(self.windows()) - windows)
        self._xdotool("type", "--delay", 50, name)
        self._xdotool("key", "--delay", 100, "Return")
        self.until(f"{active} != {before}")

    def add_deform(self, *, apply=True):
        """Create `deform`, an MLS Deform of the selected source."""
        self.launch("MLS Deform")
        self.run("deform = simple.GetActiveSource()")
        if apply:
            self.press("alt+a")
            self.until("deform.GetDataInformation().GetNumberOfPoints() > 0")

    def click(self, place):
        """Click on a place of `gui_places`, as soon as it is visible."""
        self.hover(place)
        self._xdotool("click", 1)
        self.clicks += 1

    def hover(self, place, opens=None):
        """Move the mouse to a place of `gui_places`, as soon as it is visible.

        It moves until the place that it `opens` is visible, too.
        """
        found = []

        def is_still():  # windows move as they open
            found.append(self._place(place))
            return found[-1] and found[-2:] == [found[-1]] * 2

        self._wait(is_still, place)
        x, y = found[-1]

        def is_open():
            for shift in (5, 0):  # a menu that opens under the mouse ignores the first motion
                self._xdotool("mousemove", "--sync", x + shift, y)
            return opens is None or self._place(opens)

        self._wait(is_open, opens)

    def find_and_click(self, kind, name):
        """Scroll to a place of `gui_places`, by its function and its argument, and click on it."""
        turn, place = f"to_scroll({kind!r}, {name!r})", f"{kind}({name!r})"
        self._wait(lambda: self._place(turn) or self._place(place), place)
        while before := self._place(turn):
            x, y, direction, _ = before
            self._xdotool("mousemove", x, y)  # with --sync it would wait for a motion
            self._xdotool("click", direction)
            self._wait(lambda: self._place(turn) != before, "the panel to scroll")
        self.click(place)

    def find_in_tree(self, row, column=0, clicks=1):
        """Scroll down to a cell of a tree and click on it, once or twice."""
        self.hover("tree()")
        place = f"tree_cell({row!r}, {column})"
        for _ in range(20):
            if not self._place(place):
                self._xdotool("click", WHEEL_DOWN)
        self.hover(place)
        self._xdotool("click", "--repeat", clicks, 1)

    def type(self, text):
        """Type text and Return."""
        self._xdotool("type", "--delay", 20, text)
        self._xdotool("key", "--delay", 100, "Return")

    def enter(self, text, place):
        """Type text and Return, until a place of `gui_places` is visible.

        A list of completions that opens late takes the Return.
        """
        self.type(text)
        last, tries = time.monotonic(), 0

        def is_visible():
            nonlocal last, tries
            if self._place(place):
                return True
            if time.monotonic() - last > 5:
                tries += 1
                if tries % 3 == 0:  # letters may be lost
                    self._xdotool("key", "ctrl+a")
                    self._xdotool("type", "--delay", 50, text)
                self._xdotool("key", "Return")
                last = time.monotonic()
            return False

        self._wait(is_visible, place)

    @contextmanager
    def dragging(self, place, by, key=None):
        """Drag from a place in the world by so many pixels, with a key held."""
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
        """Click on a place in the world, with a key held."""
        x, y = self._on_screen(place)
        self._xdotool("mousemove", "--sync", x, y)
        self._xdotool("keydown", key)
        self._xdotool("click", 1)
        self._xdotool("keyup", key)
        self.clicks += 1

    def windows(self):
        found = self._xdotool("search", "--onlyvisible", "--class", "paraview", check=False)
        return found.split()

    def move(self, by):
        self._xdotool("mousemove_relative", "--sync", "--", by[0], -by[1])

    def shake(self, seconds, rate=100):
        """Move the mouse back and forth by a pixel or two, `rate` times a second at most."""
        moves = [(2, 1), (-1, -2), (1, 2), (-2, -1)]
        steps = [moves[number % 4] for number in range(int(rate * seconds))]
        for part in (steps[at : at + rate // 2] for at in range(0, len(steps), rate // 2)):
            chain = (("mousemove_relative", "--", *step, "sleep", 1 / rate) for step in part)
            self._xdotool(*(word for link in chain for word in link))

    def shake_until(self, expression):
        """Move the mouse back and forth until a Python expression inside is true."""

        def is_true():
            self.shake(2)
            return self.value(f"bool({expression})")

        self._wait(is_true, expression)

    def screenshot(self, name):
        """Save the screen; returns the file."""
        path = self._folder / f"{name}.png"
        command = ["import", "-window", "root", str(path)]
        subprocess.run(command, env=self._environment, check=True, timeout=TIMEOUT)
        return path

    @property
    def pointer(self):
        found = self._xdotool("getmouselocation", "--shell").splitlines()
        return tuple(int(line.partition("=")[2]) for line in found[:2])

    @property
    def printed(self):
        """All that it printed, including Output Messages."""
        return (self._folder / "log.txt").read_text()

    def spread(self):
        """Wait for the main window, and maximize it."""
        self._wait(self.windows, "a window")
        (self._window,) = self.windows()
        self._xdotool("windowmove", self._window, 0, 0)
        self.resize(WIDTH, HEIGHT)

    def resize(self, width, height):
        self._xdotool("windowsize", "--sync", self._window, width, height)

    def _place(self, place):
        return self.run(f"import gui_places; answer = gui_places.{place}")

    def _on_screen(self, place):
        """Position on the screen of a place in the world."""
        middle = WIDTH * 2 // 3, HEIGHT // 2
        for shift in (5, 0):  # an event needs a motion
            self._xdotool("mousemove", "--sync", middle[0] + shift, middle[1])
        mouse = "view.GetInteractor()"
        self.until(f"0 < {mouse}.GetEventPosition()[0] < {mouse}.GetSize()[0]")
        position = self.value(f"list({mouse}.GetEventPosition())")
        x, y = self.value(f"on_screen([{list(place)}])[0].tolist()")
        return middle[0] + x - position[0], middle[1] - y + position[1]

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
            timeout=TIMEOUT,
        )
        return done.stdout

    def _wait(self, condition, what):
        end = time.monotonic() + TIMEOUT
        while not condition():
            assert self._process.poll() is None, f"ParaView has ended:\n{self.printed}"
            assert time.monotonic() < end, f"no {what} after {TIMEOUT} s\n{self.printed}"
            time.sleep(0.02)


@contextmanager
def running(paraview, project, folder, display, command=PLAIN, **variables):
    """A `Gui` of a `paraviews.ParaView`, started by a command with more environment variables."""
    (project / folder).mkdir(parents=True, exist_ok=True)
    for name in ("request.py", "reply.json"):
        (project / folder / name).unlink(missing_ok=True)
    environment = paraview.environment(
        DISPLAY=display,
        QT_QPA_PLATFORM="xcb",
        PARAVIEW_GUI_FOLDER=str(folder),
        MESA_SHADER_CACHE_DISABLE="true",  # cached shaders hide warnings
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
