"""Shrinks the pictures of the pages: ``.venv/bin/python docs/images/make.py``.

Draw them before, in the root of the repository: ``make demo``, ``stillreach run panda-elbow``, and for survey.png
``stillreach survey panda --samples 100000 -k 1 --metric relative --metric depth --metric reach``. One that
is not drawn stays as it is.
"""

from pathlib import Path

from PIL import Image  # comes with matplotlib

HERE = Path(__file__).parent
OUT = HERE.parents[1] / "out"
DRAWN = {
    "rehearsal.png": OUT / "demo" / "rehearsal.png",
    "figure-stillreach.png": OUT / "paper" / "figure-stillreach.png",
    "survey.png": OUT / "panda" / "survey.png",
    "panda-elbow.png": OUT / "panda-elbow" / "run.png",
}
WIDTH, COLOURS = 1040, 200

for name, file in DRAWN.items():
    if file.exists():
        picture = Image.open(file).convert("RGB")
        picture = picture.resize((WIDTH, round(picture.height * WIDTH / picture.width)), Image.Resampling.LANCZOS)
        picture.quantize(COLOURS, Image.Quantize.MEDIANCUT, kmeans=3, dither=Image.Dither.NONE).save(
            HERE / name, optimize=True
        )
