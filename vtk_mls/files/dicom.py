"""DICOM: the slices of a series, from a folder or by one of its files, by SimpleITK.

Places are those of ITK, in LPS. Values are rescaled as the slices say. Slices are sorted by place.
A slice that is missing, broken or of another size is an error: nothing is interpolated over it.
"""

import re
from pathlib import Path

import numpy as np
import SimpleITK as sitk

from vtk_mls.base.errors import InputError
from vtk_mls.files import formats, image_files
from vtk_mls.files.volumes import Volume
from vtk_mls.vtk.objects import configured

_MAX_LISTED = 6
_TOLERANCE = 0.02  # of the distance of slices
_SERIES, _DESCRIPTION, _FRAMES = "0020|000e", "0008|103e", "0028|0008"
_HEAD = 132  # bytes before any tag
_CLASS = re.compile(rb"\x02\x00\x02\x00UI..([\d.]+)[^\d.]", re.DOTALL)  # of storage
_SLICES = {b"1.2.840.10008.5.1.4.1.1." + last for last in (b"2", b"4", b"128")}  # CT, MR, PET


def read(path):
    """The image of a series: of a folder with one series, or of a file whose series is in its
    folder. Errors (OSError, ValueError) name the folder or the file.
    """
    warns = sitk.ProcessObject.GetGlobalWarningDisplay()
    sitk.ProcessObject.SetGlobalWarningDisplay(False)  # what matters is an error here
    try:
        return image_files.image_of(_read_slices(_series(path)), "DICOM")
    except RuntimeError as error:
        reason = str(error).strip().splitlines()[-1]
        raise ValueError(f"SimpleITK says: {reason.removeprefix('sitk::ERROR: ')}") from None
    finally:
        sitk.ProcessObject.SetGlobalWarningDisplay(warns)


def _series(path):
    """The files of the only series of a folder, or of the series of a file."""
    folder = path if path.is_dir() else path.parent
    series = _all_series(folder)
    if path.is_dir():
        if not series:
            raise IsADirectoryError(
                f"`{path}` is a folder; expected a file, or a folder of DICOM images, and it has "
                "none"
            )
        _check_complete(folder, series)
        if len(series) > 1:
            raise InputError(
                f"has {len(series)} series: {_listed(series)}; name a file of one of them in place "
                "of the folder"
            )
        return next(iter(series.values()))
    names = series.get(_information(path).get(_SERIES, ""), [])
    if str(path) not in names:
        return [str(path)]
    _check_complete(folder, series)
    return names


def _all_series(folder):
    """Lists of file names of the series with images, by their UIDs."""
    reader = sitk.ImageSeriesReader
    series = {}
    for uid in reader.GetGDCMSeriesIDs(str(folder)):
        names = list(reader.GetGDCMSeriesFileNames(str(folder), uid))
        try:
            series[_information(names[0]).get(_SERIES, uid)] = names
        except RuntimeError:  # structures, reports
            continue
    return series


def _check_complete(folder, series):
    """Raise ValueError if a file of DICOM in a folder cannot be read."""
    listed = {name for names in series.values() for name in names}
    classes = {_storage_class(Path(names[0]).read_bytes()) for names in series.values()}
    for file in sorted(folder.iterdir()):
        if file.name.upper() == "DICOMDIR" or str(file) in listed or not file.is_file():
            continue
        if _is_broken(file, {b"", *_SLICES, *classes}):
            raise ValueError(f"its file `{file.name}` is broken, and may be a slice")


def _is_broken(file, classes):
    """Whether a file that is not readable as an image is meant to be one, of these storage classes.

    Reports, structures and presentations have other classes, and no number of rows, (0028,0010).
    """
    if not formats.is_dicom_file(file):  # cut off before the magic, or of another format
        is_named = file.suffix.lower() == ".dcm" and not file.name.startswith(".")
        return is_named and file.stat().st_size < _HEAD
    content = file.read_bytes()
    return b"\x28\x00\x10\x00" in content or _storage_class(content) in classes


def _storage_class(content):
    """The storage class of a file, b"" if it has none or is cut off in it."""
    found = _CLASS.search(content)
    return found[1] if found else b""


def _listed(series):
    parts = []
    for names in list(series.values())[:_MAX_LISTED]:
        description = _information(names[0]).get(_DESCRIPTION, "").strip() or "no description"
        parts.append(f"{description} ({len(names)} slices, `{Path(names[0]).name}`)")
    more = f", and {len(series) - _MAX_LISTED} more" * (len(series) > _MAX_LISTED)
    return ", ".join(parts) + more


def _information(name):
    """The tags of a file."""
    reader = _opened(name)
    return {key: reader.GetMetaData(key) for key in reader.GetMetaDataKeys()}


def _opened(name):
    """ITK's reader of a file, which has read its tags."""
    reader = configured(sitk.ImageFileReader(), ImageIO="GDCMImageIO", FileName=str(name))
    reader.ReadImageInformation()
    return reader


def _read_slices(names):
    readers = [_opened(name) for name in names]
    for name, reader in zip(names, readers):
        _check_frames(name, reader)
    order = _order(names, readers)
    series = configured(sitk.ImageSeriesReader(), ImageIO="GDCMImageIO")
    configured(series, FileNames=[names[i] for i in order], OutputPixelType=_common_type(readers))
    image = series.Execute()
    values = sitk.GetArrayFromImage(image)
    direction = np.reshape(image.GetDirection(), (3, 3))
    return Volume(values, np.array(image.GetOrigin()), direction * image.GetSpacing())


def _common_type(readers):
    """ITK's type that holds the values of all slices, each rescaled by its own slope."""
    types = {reader.GetPixelID() for reader in readers}
    if len(types) == 1:
        return types.pop()
    dtype = np.result_type(*(sitk.GetArrayViewFromImage(sitk.Image(1, 1, t)) for t in types))
    return sitk.GetImageFromArray(np.zeros((1, 1), dtype)).GetPixelID()


def _check_frames(name, reader):
    frames = reader.GetMetaData(_FRAMES) if reader.HasMetaDataKey(_FRAMES) else "1"
    size = (*reader.GetSize(), 1)
    if size[2] > 1 or frames.strip() not in ("", "0", "1"):
        raise ValueError(
            f"`{Path(name).name}` has several images in one file (enhanced DICOM), whose places "
            "SimpleITK does not read; convert it first, such as by dcm2niix"
        )


def _order(names, readers):
    """Indices of slices, sorted by their places; raises if these are not equally far apart."""
    first = readers[0]
    for name, reader in zip(names, readers):
        for what, own, expected in (
            ("size", reader.GetSize()[:2], first.GetSize()[:2]),
            ("spacing", reader.GetSpacing()[:2], first.GetSpacing()[:2]),
            ("direction", reader.GetDirection(), first.GetDirection()),
            ("number of components", *([r.GetNumberOfComponents()] for r in (reader, first))),
        ):
            if not np.allclose(own, expected, rtol=1e-4, atol=1e-4):
                sides = (
                    f"{', '.join(f'{value:g}' for value in values)} in `{Path(file).name}`"
                    for values, file in ((own, name), (expected, names[0]))
                )
                raise ValueError(f"the slices must have one {what}, got {' and '.join(sides)}")
    origins = np.array([reader.GetOrigin() for reader in readers])
    normal = np.reshape(first.GetDirection(), (3, 3))[:, 2]
    heights = (origins - origins[0]) @ normal
    order = np.argsort(heights, kind="stable")
    steps = np.diff(heights[order])
    if len(steps) == 0:
        return order
    step = float(np.median(steps))
    tolerance = _TOLERANCE * step
    for i, gap in enumerate(steps):
        before, after = (f"`{Path(names[order[i + n]]).name}`" for n in (0, 1))
        if gap <= _TOLERANCE * step or step <= 0:
            raise ValueError(
                f"{before} and {after} are slices of the same place: several times or echoes; put "
                "each into a folder of its own"
            )
        if abs(gap - step) > tolerance:
            count = round(gap / step) - 1
            missing = f"{count} slices are" if count > 1 else "a slice is"
            reason = f"{missing} missing between" if count else "distances differ between"
            raise ValueError(f"{reason} {before} and {after}: {gap:g} apart, others {step:g}")
    shift = origins - origins[0] - np.outer(heights, normal)
    if np.abs(shift).max() > tolerance:
        raise ValueError(
            f"the slices are shifted against each other by up to {np.abs(shift).max():g} (a tilted "
            "gantry), which ITK cannot place"
        )
    return order
