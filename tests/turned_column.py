"""A column of control points whose top turns by 360 degrees."""

import numpy as np

CENTER = np.array([4.0, 3.5, 0])
SIDES = np.array([(a, b) for a in (1.5, 4, 6.5) for b in (1.5, 3.5, 5.5)])
REST = np.array([(*side, z) for z in (0.0, 2.2, 4.4, 6.6) for side in SIDES])
LEGS = 12


def turned(share, rest=REST, center=CENTER, height=6.6):
    """The column after a share of the turn."""
    angle = 2 * np.pi * share * rest[:, 2] / height
    x, y = (rest[:, :2] - center[:2]).T
    c, s = np.cos(angle), np.sin(angle)
    return np.c_[c * x - s * y, s * x + c * y, rest[:, 2]] + center
