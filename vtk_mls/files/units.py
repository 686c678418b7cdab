"""Units of length and of time, by their names in files."""

from __future__ import annotations

import re

_EXPONENTS = {
    **dict(zip("YZEPTGMkmunpfazy", [*range(24, 0, -3), *range(-3, -25, -3)])),
    **{"h": 2, "da": 1, "": 0, "d": -1, "c": -2},
}
_BILLIONTHS = {prefix: 10.0 ** (9 + exponent) for prefix, exponent in _EXPONENTS.items()}
NANOMETERS = {
    **{f"{prefix}m": billionths for prefix, billionths in _BILLIONTHS.items()},
    **{"angstrom": 0.1, "li": 2.54e7 / 12, "pt": 2.54e7 / 72, "thou": 2.54e4, "in": 2.54e7},
    **{"ft": 3.048e8, "yd": 9.144e8, "mi": 1.609344e12},
    **{"ua": 1.495978707e20, "ly": 9.4607304725808e24, "pc": 3.0856775814913673e25},
}
_NANOSECONDS = {
    **{f"{prefix}s": billionths for prefix, billionths in _BILLIONTHS.items()},
    **{"min": 6e10, "h": 3.6e12, "d": 8.64e13},
}
_WORDS = {"": "", "kilo": "k", "centi": "c", "milli": "m", "micro": "u", "nano": "n"}
_SYMBOLS = {
    **{
        f"{word}{unit}": word_symbol + unit[0]
        for word, word_symbol in _WORDS.items()
        for unit in ("meter", "metre", "second")
    },
    **{"micron": "um", "inch": "in", "inche": "in", "\u00e5": "angstrom"},
    **{"sec": "s", "msec": "ms", "usec": "us", "minute": "min", "hour": "h", "day": "d"},
}


def symbol(name):
    """The symbol of a unit of length or time; the name itself for another unit."""
    text = re.sub("\u00b5|\u03bc|\\\\u00b5", "u", name.strip())
    lower = text.lower()
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
