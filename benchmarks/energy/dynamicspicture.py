"""Energy, RMSD and radius of gyration of trials and of Langevin dynamics by processor time."""

from openmmchaintree.command.pictures.figures import makeFigure, writeFigure
from racing.races import OURS

from .dynamicstables import describeWork, ofContestants

_COLORS = {OURS: "#1f5f8b"}
_OTHER = "#d55e00"
_PANELS = {
    "energy": "U but bonds and\nangles, kJ/mol",
    "rmsd": "RMSD of Cα\nfrom the start, nm",
    "rg": "radius of\ngyration, nm",
    "turned": "χ that have left\ntheir rotamer, %",
}
_FONT = 8.5


def hasPicture(entries):
    """Return whether there is anything to draw."""
    return any(len(ofOne) > 1 for ofOne in ofContestants(entries).values())


def savePicture(output, machine, entries):
    """Write the picture of entries to an Output."""
    first = entries[0]
    figure = makeFigure(8.4, 7.6)
    figure.suptitle(
        f"{first['chain']}, {first['particles']:,} atoms, AMBER14 with GBn2, 300 K, one core; {machine['processor']}",
        fontsize="medium",
    )
    axes = figure.subplots(len(_PANELS), 1, sharex=True)
    for axis, (key, label) in zip(axes, _PANELS.items(), strict=True):
        for name, ofOne in ofContestants(entries).items():
            minutes = [entry["seconds"] / 60 for entry in ofOne]
            values = [100 * entry[key] if key == "turned" else entry[key] for entry in ofOne]
            words = f"{name}: {describeWork(ofOne[-1])}"
            axis.plot(minutes, values, color=_COLORS.get(name, _OTHER), linewidth=1, label=words)
        axis.set_ylabel(label, fontsize=_FONT)
        axis.tick_params(labelsize=_FONT - 1)
        axis.grid(color="0.9", linewidth=0.8)
        axis.set_axisbelow(True)
    axes[-1].set_xlabel("processor time, minutes", fontsize=_FONT)
    axes[-1].set_xlim(left=0)
    axes[-1].set_ylim(0, 100)
    figure.legend(
        *axes[0].get_legend_handles_labels(), loc="outside lower center", ncols=2, fontsize=_FONT, frameon=False
    )
    writeFigure(figure, output)
