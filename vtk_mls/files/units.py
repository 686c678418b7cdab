"""Units of length and of time, by their names in files."""

import re

_POWERS = {"k": 12, "": 9, "d": 8, "c": 7, "m": 6, "u": 3, "n": 0, "p": -3}  # of ten, to billionths
NANOMETERS = {
    **{f"{prefix}m": 10.0**power for prefix, power in _POWERS.items()},
    **{"angstrom": 0.1, "in": 2.54e7, "ft": 3.048e8, "yd": 9.144e8},
}
_NANOSECONDS = {
    **{f"{prefix}s": 10.0**power for prefix, power in _POWERS.items()},
    **{"min": 6e10, "h": 3.6e12, "d": 8.64e13},
}
_WORDS = {"": "", "kilo": "k", "centi": "c", "milli": "m", "micro": "u", "nano": "n", "pico": "p"}
_SYMBOLS = {
    **{
        f"{word}{unit}": word_symbol + unit[0]
        for word, word_symbol in _WORDS.items()
        for unit in ("meter", "metre", "second")
    },
    **{"micron": "um", "inch": "in", "inche": "in", "foot": "ft", "yard": "yd"},
    **{"\u00e5": "angstrom", "sec": "s", "msec": "ms", "usec": "us"},
    **{"minute": "min", "hour": "h", "day": "d"},
}


def symbol(name):
    """The symbol of a unit of length or time; the name itself for another unit."""
    text = re.sub("\u00b5|\u03bc|\\\\u00b5", "u", name.strip())
    lower = text if text in ("Mm", "Pm") else text.lower()  # those are large
    names = text, lower, *(_SYMBOLS.get(word, "") for word in (lower, lower.removesuffix("s")))
    return next((known for known in names if known in NANOMETERS or known in _NANOSECONDS), name)


def in_seconds(name, *times):
    """Times in seconds, and "s"; unchanged, with the name, if it is not of a unit of time."""
    nanoseconds = _NANOSECONDS.get(symbol(name))
    if nanoseconds is None:
        return times, name
    return tuple(time * nanoseconds / 1e9 for time in times), "s"


def from_seconds(name, *times):
    """Times in a unit; unchanged if it is not of time."""
    nanoseconds = _NANOSECONDS.get(symbol(name), 1e9)
    return tuple(time * 1e9 / nanoseconds for time in times)
