"""`vtk-mls view`: the editor on a page, or in a window."""

from pathlib import Path

from vtk_mls.commands import map_options, running
from vtk_mls.commands.running import files_named, read
from vtk_mls.commands.supervision import step, temporary_folder
from vtk_mls.editor import State, sessions, time_steps
from vtk_mls.editor.handle_polydata import handle_values
from vtk_mls.editor.matching.target import Target
from vtk_mls.files import session_files
from vtk_mls.files.image_files import read_ome_zarr
from vtk_mls.files.ome_zarr import is_ome_zarr
from vtk_mls.files.paths import check_folder, check_replaceable
from vtk_mls.files.vtk_io import failures_named
from vtk_mls.model.options import KIND

MAX_POINTS = 1 << 24  # of a level of an OME-Zarr; the finest level is saved
_WEB_PACKAGES = "aiohttp", "trame", "trame_client", "trame_vuetify"  # of the extra `web`


def add(view):
    view.description = (
        "Deform an image or a mesh by the mouse, on a page that opens in a browser: "
        "drag handles, see the result at once, undo, save."
    )
    view.add_argument(
        "input",
        help="image or mesh, of any format that `vtk-mls deform` reads; of an OME-Zarr the finest "
        "resolution of at most 2^24 points is edited, and all are saved; or a session, .mls.json, "
        "or the folder of a save",
    )
    view.add_argument(
        "handles",
        nargs="?",
        help=f"{map_options.HANDLES}; by default they are placed over the data",
    )
    view.add_argument(
        "--with",
        dest="others",
        metavar="FILE",
        action="append",
        default=[],
        help="another image or mesh, which the same handles move (may be repeated)",
    )
    view.add_argument(
        "--target",
        metavar="FILE",
        help="image or mesh that the input is to match: landmarks are placed in pairs, on both",
    )
    view.add_argument(
        "--output",
        metavar="FOLDER",
        help="folder of saved files; by default a new one named after the input. With the ending "
        ".mls.json, a session file, and a folder of its name for the other files",
    )
    view.add_argument(
        "--no-browser",
        "--web",
        action="store_true",
        help="only print the address of the page; this machine draws, and needs no display",
    )
    view.add_argument(
        "--window",
        action="store_true",
        help="in a plain window with the keys of the page, without its panel and tables",
    )
    view.add_argument(
        "--host",
        default="127.0.0.1",
        help="address of the page; by default only this machine can reach it",
    )
    view.add_argument("--port", type=int, help="port of the page; by default 8080, or a free one")
    map_options.add(view, is_interactive=True)


def run(options):
    if options.output is not None:
        check = check_replaceable if session_files.is_session(options.output) else check_folder
        check(options.output)
    if options.handles is None and options.deformed:
        raise ValueError("`--deformed` has the new positions of handles: name their file, too")
    folder_session = Path(options.input) / session_files.NAME
    if folder_session.is_file():  # what S has saved
        options.output = options.output or options.input
        options.input = folder_session
    if session_files.is_session(options.input):
        return _resume(options)
    paths = options.input, *options.others
    datasets = [_dataset(path) for path in paths]
    state, target = _state(options), _target(options.target)
    with step("show", options.input):
        _show(options, datasets, state, paths, target)
    return 0


def _resume(options):
    path = Path(options.input)
    if options.handles is not None or options.others or options.target is not None:
        raise ValueError(
            f"`{path}` is a session, which has its own data, handles and target: name no others"
        )
    session = read(session_files.read, path)
    session_files.check_files(session, path)
    state = sessions.state_of(session, path)
    datasets, target = [_dataset(file) for file in session.data], _target(session.target)
    with step("show", path):
        _show(options, datasets, state, session.data, target, (path, session.views))
    return 0


def _dataset(path):
    dataset = read(_read_dataset, path)
    if not dataset.IsA("vtkDataSet"):
        raise ValueError(f"`{path}` has blocks, and the editor shows single images and meshes")
    return dataset


def _read_dataset(path):
    """The dataset of a file, at its first time; of an OME-Zarr, a level that is not too large."""
    if not is_ome_zarr(path):
        return time_steps.read(path)
    with failures_named(path):
        return read_ome_zarr(path, MAX_POINTS)


def _target(path):
    return None if path is None else Target(_dataset(path), path)


def _show(options, datasets, state, paths, *more):
    if options.window:
        from vtk_mls.editor import window

        window.show(datasets, state, paths, options.output, *more)
        return
    try:
        from vtk_mls.web import server
    except ModuleNotFoundError as error:
        if (error.name or "").partition(".")[0] not in _WEB_PACKAGES:
            raise
        raise OSError(
            "the page needs trame, which is not installed: pip install trame trame-vuetify; or "
            "`--window` opens a plain window"
        ) from error
    with temporary_folder() as temporary:
        served = datasets, state, paths, temporary, options.output, (options.host, options.port)
        server.serve(*served, not options.no_browser, *more)


def _state(options):
    """The initial state of the editor, which adds handles if it has none."""
    options.kind = options.kind or (KIND.default if options.target is None else "auto")
    arguments = {**running.map_arguments(options), "blend": options.blend}
    del arguments["constraints"]  # which the editor has none of
    if options.handles is None:
        return State([], [], **arguments)
    with files_named(options):
        values = handle_values(running.read_control_points(options)[0], options.handle_shapes)
    return State(**values, **arguments)
