"""Shrinks the picture of the README: ``.venv/bin/python docs/images/make.py`` after ``make demo``."""

from pathlib import Path

from PIL import Image  # comes with matplotlib

HERE = Path(__file__).parent
DRAWN = HERE.parents[1] / "out" / "paper" / "figure-stillreach.png"
WIDTH, COLOURS = 1040, 128

picture = Image.open(DRAWN).convert("RGB")
picture = picture.resize((WIDTH, round(picture.height * WIDTH / picture.width)), Image.Resampling.LANCZOS)
picture.quantize(COLOURS, method=Image.Quantize.MAXCOVERAGE).save(HERE / DRAWN.name, optimize=True)
