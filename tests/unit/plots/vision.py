"""Colours as readers see them: lightness, contrast, and distances with deuteranopia.

Distances are CIE 1976 in Lab under D65; deuteranopia is the full-strength matrix of Machado,
Oliveira and Fernandes (2009), in linear sRGB.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.colors import to_rgb

from remanent._typing import FloatArray

#: Linear sRGB to XYZ.
_XYZ = np.array(
    [
        [0.4124564, 0.3575761, 0.1804375],
        [0.2126729, 0.7151522, 0.0721750],
        [0.0193339, 0.1191920, 0.9503041],
    ]
)
#: White of D65.
_WHITE = np.array([0.95047, 1.0, 1.08883])
#: Linear sRGB as a reader with deuteranopia sees it.
DEUTERANOPIA = np.array(
    [
        [0.367322, 0.860646, -0.227968],
        [0.280085, 0.672501, 0.047413],
        [-0.011820, 0.042940, 0.968881],
    ]
)
#: The same for the usual reader.
NORMAL = np.eye(3)


def linear(colours: Any) -> FloatArray:
    """Linear sRGB of colours as Matplotlib understands them, array (colour, 3)."""
    rgb = np.array([to_rgb(colour) for colour in colours])
    return np.where(rgb <= 0.04045, rgb / 12.92, ((rgb + 0.055) / 1.055) ** 2.4)


def lab(colours: Any, eye: FloatArray = NORMAL) -> FloatArray:
    """Lab of colours, array (colour, 3)."""
    xyz = np.clip(linear(colours) @ eye.T, 0.0, 1.0) @ _XYZ.T / _WHITE
    f = np.where(xyz > 216 / 24389, np.cbrt(xyz), (24389 / 27 * xyz + 16) / 116)
    x, y, z = f.T
    return np.stack([116 * y - 16, 500 * (x - y), 200 * (y - z)], axis=-1)


def lightness(colours: Any) -> FloatArray:
    """L* of colours, which a grey print keeps."""
    return np.asarray(lab(colours)[:, 0])


def distances(first: Any, second: Any, eye: FloatArray = NORMAL) -> FloatArray:
    """Distance of each of the first from each of the second, array (first, second)."""
    apart = lab(first, eye)[:, None] - lab(second, eye)[None]
    return np.asarray(np.linalg.norm(apart, axis=-1))


def contrast_with_white(colours: Any) -> FloatArray:
    """Contrast ratio with white paper (WCAG 2.1)."""
    return np.asarray(1.05 / (linear(colours) @ _XYZ[1] + 0.05))
