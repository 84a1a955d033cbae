"""The picture of why it is fast: rows a second, and where their instructions go."""

from pathlib import Path

from bench.batch import LAWS, Result
from bench.plot import OURS, plain
from bench.stages import Count

COLOURS = ("#b5533c", "#d9a08a", "#1a7f5a", "#9cc3b0", "#5b7fa6", "#c9b458", "#b8b8b8", "#505050")


def draw(result: Result, counts: list[Count], path: Path) -> None:
    """Writes the PNG."""
    import matplotlib as mpl

    mpl.use("Agg")
    from matplotlib import pyplot as plt

    figure, (left, right) = plt.subplots(1, 2, figsize=(10.0, 3.9), sharey=True, layout="constrained")
    names = [name for name in LAWS if any(one.law == name for one in counts)][::-1]
    rates = {one.name: one for one in result.of("laws")}
    bars = left.barh(list(map(plain, names)), [rates[name].rate for name in names], color=OURS)
    left.bar_label(bars, labels=[f"{rates[name].rate:.2f}" for name in names], padding=3, fontsize=8)
    for place, name in enumerate(names):
        if need := rates[name].need:
            left.plot([need, need], [place - 0.4, place + 0.4], color="black", linewidth=1.2)
    left.set_title("million rows a second, one thread (lines: required)", loc="left", fontsize=9)
    by_law = {one.law: one for one in counts}
    start = dict.fromkeys(names, 0.0)
    for stage, colour in zip(counts[0].stages, COLOURS, strict=True):
        parts = [by_law[name].stages[stage] for name in names]
        right.barh(list(map(plain, names)), parts, left=list(start.values()), color=colour, label=stage)
        start = {name: start[name] + part for name, part in zip(names, parts, strict=True)}
    right.set_title("instructions a row (four rows share a vector one)", loc="left", fontsize=9)
    for axis in (left, right):
        axis.tick_params(labelsize=8)
        axis.spines[["top", "right"]].set_visible(False)
    left.margins(x=0.12)
    figure.legend(*right.get_legend_handles_labels(), loc="outside lower center", ncols=4, fontsize=8, frameon=False)
    figure.savefig(path, dpi=110, metadata={"Software": None})
    plt.close(figure)
