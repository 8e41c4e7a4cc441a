"""Pictures of pages as small files: lines and letters need few colours."""

from __future__ import annotations

import io
from pathlib import Path
from typing import Any, Final

from PIL import Image

#: Colours of a picture. Each pixel is then one byte, which lines and letters compress well.
COLOUR_COUNT: Final = 128


def save_picture(figure: Any, file: Path, *, dpi: float) -> None:
    """Write a Matplotlib figure as PNG in few colours, without dithering."""
    drawn = io.BytesIO()
    figure.savefig(drawn, dpi=dpi)
    with Image.open(drawn) as image:
        few = image.convert("RGB").quantize(COLOUR_COUNT, dither=Image.Dither.NONE)
    few.save(file, optimize=True)
