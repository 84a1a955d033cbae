"""Every picture of the report, drawn from the saved runs: the paper's figures in order, then those beside them."""

from __future__ import annotations

from pathlib import Path

from stillreach.paper.added import ADDED
from stillreach.paper.evidence import Evidence
from stillreach.paper.printed import PRINTED
from stillreach.show.style import styled

PICTURES = PRINTED + ADDED


def write(evidence: Evidence, out: Path) -> None:
    """Draw every picture into a folder.

    Raises:
        MissingExtraError: matplotlib is not installed.
    """
    with styled("the paper's figures"):
        for picture in PICTURES:
            picture.draw(evidence).savefig(out / picture.file, pil_kwargs={"compress_level": 2})
