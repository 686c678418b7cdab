"""Draw posed.png, straightened.png and local.png: `python docs/handles_picture.py`, with `.[docs]`.

You will see the pictures of three examples of the gallery, with fewer colors and so smaller.
"""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
from pathlib import Path

from PIL import Image

EXAMPLES = {"posed_bones": "posed", "straightened": "straightened", "local_drag": "local"}
WIDTH = 1200


def draw(folder):
    """Run the examples and write their pictures to a folder."""
    scripts = Path(__file__).resolve().parents[1] / "examples"
    with tempfile.TemporaryDirectory() as made:
        for example, name in EXAMPLES.items():
            command = [sys.executable, str(scripts / f"{example}.py")]
            environment = {**os.environ, "PYVISTA_OFF_SCREEN": "true"}
            subprocess.run(command, cwd=made, env=environment, check=True)
            picture = Image.open(Path(made) / f"{example}.png").convert("RGB")
            picture = picture.resize((WIDTH, WIDTH * picture.height // picture.width))
            # the method keeps colors that few pixels have, such as those of handles
            picture = picture.quantize(256, method=Image.Quantize.MAXCOVERAGE)
            picture.save(folder / f"{name}.png", optimize=True)


if __name__ == "__main__":
    draw(Path(__file__).parent)
