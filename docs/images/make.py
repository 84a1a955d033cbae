"""Shrinks the pictures of the pages: ``.venv/bin/python docs/images/make.py``.

Draw them before, in the root of the repository: ``make demo``, ``stillreach run panda-elbow``; for survey.png
``stillreach survey panda --samples 100000 -k 1 --metric relative --metric depth --metric reach --metric positions``;
for slice and cloud ``stillreach survey panda --samples 20000 -k 1 --metric positions --out out/positions``. One that
is not drawn stays as it is. still-goes.png is a picture of the page of docs/rehearsal.md with ``--survey 1000``.
"""

from pathlib import Path

from PIL import Image  # comes with matplotlib

HERE = Path(__file__).parent
OUT = HERE.parents[1] / "out"
DRAWN = {
    "rehearsal.png": OUT / "demo" / "rehearsal.png",
    "figure-stillreach.png": OUT / "paper" / "figure-stillreach.png",
    "survey.png": OUT / "panda" / "survey.png",
    "survey-slice.png": OUT / "positions" / "survey-slice.png",
    "survey-cloud.png": OUT / "positions" / "survey-cloud.png",
    "still-goes.png": OUT / "still-goes.png",
    "panda-elbow.png": OUT / "panda-elbow" / "run.png",
}
WIDTH, COLOURS = 1040, 200
NARROW = {"survey-cloud.png": 720}

for name, file in DRAWN.items():
    if file.exists():
        picture = Image.open(file).convert("RGB")
        width = NARROW.get(name, WIDTH)
        picture = picture.resize((width, round(picture.height * width / picture.width)), Image.Resampling.LANCZOS)
        picture.quantize(COLOURS, Image.Quantize.MEDIANCUT, kmeans=3, dither=Image.Dither.NONE).save(
            HERE / name, optimize=True
        )
