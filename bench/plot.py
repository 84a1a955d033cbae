"""The picture of the tables: time on a logarithmic axis, and whether the answers were right."""

from pathlib import Path

from bench.field import Peer
from bench.report import measured

OURS, RIGHT, WRONG = "#1a7f5a", "#5b7fa6", "#c9a08a"


def draw(ticks: list[Peer], batches: list[Peer], path: Path) -> None:
    """Writes the PNG."""
    import matplotlib as mpl

    mpl.use("Agg")
    from matplotlib import pyplot as plt
    from matplotlib.patches import Patch
    from matplotlib.ticker import NullFormatter

    tables = [
        (peers, title) for peers, title in ((ticks, "one tick"), (batches, "a row of a batch")) if measured(peers)
    ]
    heights = [len(measured(peers)) for peers, _ in tables]
    figure, axes = plt.subplots(
        len(tables),
        1,
        figsize=(8.5, 1.6 + 0.3 * sum(heights)),
        height_ratios=heights,
        squeeze=False,
        layout="constrained",
    )
    for (peers, title), axis in zip(tables, axes[:, 0], strict=True):
        shown = measured(peers)[::-1]
        bars = axis.barh(
            [plain(p.entry.title) for p in shown], [p.best for p in shown], color=[colour(p) for p in shown]
        )
        axis.bar_label(bars, labels=[f"{p.best:.3g}" for p in shown], padding=3, fontsize=8)
        axis.set_xscale("log")
        axis.xaxis.set_minor_formatter(NullFormatter())
        axis.margins(x=0.12)
        axis.tick_params(labelsize=8)
        axis.set_title(f"{title} [µs]", loc="left", fontsize=9)
        axis.spines[["top", "right"]].set_visible(False)
    names = [
        "stillreach, inside limits, no feasible twist missed",
        "another library, likewise",
        "misses feasible twists or exceeds limits",
    ]
    patches = [Patch(color=c, label=name) for c, name in zip((OURS, RIGHT, WRONG), names, strict=True)]
    figure.legend(handles=patches, loc="outside lower center", ncols=3, fontsize=8, frameon=False)
    figure.savefig(path, dpi=110, metadata={"Software": None})
    plt.close(figure)


def plain(title: str) -> str:
    """Without Markdown."""
    return title.replace("`", "")


def colour(peer: Peer) -> str:
    """Whose it is, and what it is worth."""
    if peer.verdict is None or not peer.verdict.clean:
        return WRONG
    return OURS if peer.entry.ours else RIGHT
