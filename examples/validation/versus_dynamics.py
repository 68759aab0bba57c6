"""How much does a protein move in minutes of one processor core: by Monte Carlo, and by dynamics?

    python versus_dynamics.py run moves 1l2y.pdb moves.npz --seconds 300
    python versus_dynamics.py run dynamics 1l2y.pdb dynamics.npz --seconds 300
    python versus_dynamics.py draw 1l2y.pdb moves.npz dynamics.npz versus-dynamics.png

`run` samples a protein with all its hydrogens, such as trp-cage (PDB entry 1L2Y), in AMBER14 with GBn2 at 300 K. Each
run starts from the minimized structure and ends after --seconds of CPU time. `moves` are those of addDefaultMoves and
as many displacements of single atoms: `sample --flexible`. `dynamics` is LangevinMiddleIntegrator with constrained
bonds of hydrogens of 1.5 Da and a step of 4 fs, on OpenMM's CPU platform with one thread.

`draw` takes the CPU time that both runs have, and omits the first fifth. It prints and draws effective sample sizes
(for angles the median of all of a kind) and how often side chains change the rotamer of chi1, and draws Ramachandran
plots and the RMSD of backbone atoms from the start against CPU time. An angle that stays in its basin has a large
effective size there, but says nothing of other basins; the changes of rotamers do.
"""

import argparse
import sys
import time

import matplotlib
import mdtraj
import numpy as np
import openmm
import openmm.app as app
import openmmchaintree as chaintree
from openmm import unit
from openmmchaintree.command.flexible import LARGEST_SIZE, findScales
from openmmchaintree.statistics.estimates import estimate, estimateAngle

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402

TEMPERATURE = 300 * unit.kelvin
TRIALS_PER_STEP, STEPS_OF_MOVES, STEPS_OF_DYNAMICS = 400, 10, 10  # between frames
PLATFORM = (openmm.Platform.getPlatformByName("CPU"), {"Threads": "1"})
SECONDS_BETWEEN_FILES = 20
DISCARDED = 0.2  # of each run, before its statistics
ROTAMERS, CORE = (60, 180, 300), 30  # degrees: centres of rotamers, and half the width of their cores
COLORS = {"moves": "#1f6fb4", "dynamics": "#d9730d"}
NAMES = {"moves": "openmm-chaintree", "dynamics": "dynamics"}


# ---- Runs ----


def run(options):
    """Run one method and write its frames; return the exit status."""
    topology, positions = readMinimized(options.structure)
    make, steps = {"moves": (makeMoves, STEPS_OF_MOVES), "dynamics": (makeDynamics, STEPS_OF_DYNAMICS)}[options.method]
    simulation, getEnergy = make(topology, positions, options.seed)
    frames, energies, seconds = [], [], []
    start, written = time.process_time(), 0.0
    while not seconds or seconds[-1] < options.seconds:
        simulation.step(steps)
        state = simulation.context.getState(positions=True)
        frames.append(state.getPositions(asNumpy=True).value_in_unit(unit.nanometer).astype(np.float32))
        energies.append(getEnergy())
        seconds.append(time.process_time() - start)
        if not seconds[-1] < min(options.seconds, written + SECONDS_BETWEEN_FILES):
            np.savez(options.output, frames=frames, energies=energies, seconds=seconds)
            written = seconds[-1]
    return 0


def readMinimized(structure):
    """Return the Topology and the minimized positions of a PDB file."""
    pdb = app.PDBFile(structure)
    pdb.topology.setPeriodicBoxVectors(None)
    simulation = app.Simulation(pdb.topology, makeSystem(pdb.topology), openmm.VerletIntegrator(0.001), *PLATFORM)
    simulation.context.setPositions(pdb.positions)
    simulation.minimizeEnergy()
    return pdb.topology, simulation.context.getState(positions=True).getPositions()


def makeSystem(topology, **options):
    return app.ForceField("amber14-all.xml", "implicit/gbn2.xml").createSystem(topology, **options)


def makeMoves(topology, positions, seed):
    """Return a Simulation by moves, and a function that returns its energy in kJ/mol."""
    system = makeSystem(topology)
    system.addForce(chaintree.createStericExclusionForce(topology, positions, system=system))
    integrator = chaintree.TorsionMonteCarloIntegrator(TEMPERATURE)
    integrator.setRandomNumberSeed(seed)
    integrator.setTrialsPerStep(TRIALS_PER_STEP)
    moves = chaintree.addDefaultMoves(integrator, topology, system)  # the sum of their weights is 1
    integrator.addAtomMove(1, LARGEST_SIZE * unit.nanometer)
    integrator.setMoveScales(len(moves), findScales(integrator, system, positions, PLATFORM))
    simulation = app.Simulation(topology, system, integrator, *PLATFORM)
    simulation.context.setPositions(positions)
    return simulation, lambda: integrator.getPotentialEnergy(simulation.context)


def makeDynamics(topology, positions, seed):
    """Return a Simulation by dynamics, and a function that returns its energy in kJ/mol."""
    system = makeSystem(topology, constraints=app.HBonds, hydrogenMass=1.5 * unit.dalton)
    integrator = openmm.LangevinMiddleIntegrator(TEMPERATURE, 1 / unit.picosecond, 4 * unit.femtosecond)
    integrator.setRandomNumberSeed(seed)
    simulation = app.Simulation(topology, system, integrator, *PLATFORM)
    simulation.context.setPositions(positions)
    simulation.context.setVelocitiesToTemperature(TEMPERATURE, seed)

    def getEnergy():
        energy = simulation.context.getState(energy=True).getPotentialEnergy()
        return energy.value_in_unit(unit.kilojoule_per_mole)

    return simulation, getEnergy


# ---- The picture ----


class Course:
    """A run as `draw` shows it: angles in rad, RMSD in Å, CPU time in s."""

    def __init__(self, structure, data, seconds):
        """Take the frames of the file of a run up to some CPU time."""
        count = int(np.count_nonzero(data["seconds"] <= seconds))
        self.seconds = data["seconds"][:count]
        self.kept = slice(int(DISCARDED * count), None)
        trajectory = mdtraj.Trajectory(data["frames"][:count], mdtraj.load(structure).topology)
        start = mdtraj.load_frame(structure, 0)
        self.rmsd = 10 * mdtraj.rmsd(trajectory, start, atom_indices=trajectory.topology.select("backbone"))
        self.phi, self.psi, self.chi1 = (
            compute(trajectory)[1] for compute in (mdtraj.compute_phi, mdtraj.compute_psi, mdtraj.compute_chi1)
        )
        self._energies, self._sizes = data["energies"][:count], 10 * mdtraj.compute_rg(trajectory)

    def countRotamerChanges(self):
        """Return how often a chi1 reaches the core of another rotamer than it was in last."""
        changes = 0
        for angles in np.degrees(self.chi1[self.kept]).T:
            rotamers = np.full(len(angles), -1)
            for number, center in enumerate(ROTAMERS):
                rotamers[np.abs((angles - center + 180) % 360 - 180) < CORE] = number
            reached = rotamers[rotamers >= 0]
            changes += int(np.count_nonzero(reached[1:] != reached[:-1]))
        return changes

    def count(self):
        """Return effective sample sizes of the frames that count, by the names of observables, and rotamer changes."""

        def ofAngles(angles):
            return float(np.median([estimateAngle([one]).effectiveSampleSize for one in angles[self.kept].T]))

        series = {"energy": self._energies, "radius of gyration": self._sizes, "RMSD": self.rmsd}
        sizes = {name: estimate([values[self.kept]]).effectiveSampleSize for name, values in series.items()}
        angles = {"φ": self.phi, "ψ": self.psi, "χ1": self.chi1}
        sizes |= {name: ofAngles(values) for name, values in angles.items()}
        return sizes | {"χ1, changes\nof rotamers": self.countRotamerChanges()}


def draw(options):
    """Draw two runs, and print their counts; return the exit status."""
    files = {name: np.load(getattr(options, name)) for name in COLORS}
    seconds = min(file["seconds"][-1] for file in files.values())
    courses = {name: Course(options.structure, file, seconds) for name, file in files.items()}
    sizes = {name: course.count() for name, course in courses.items()}
    for observable in sizes["moves"]:
        name = observable.replace("\n", " ")
        print(f"{name:24} {sizes['moves'][observable]:8.0f} {sizes['dynamics'][observable]:8.0f}")
    figure, panels = plt.subplot_mosaic("mdb;ttb", figsize=(11, 6.2), layout="constrained")
    for panel, (name, course) in zip("md", courses.items(), strict=True):
        _drawAngles(panels[panel], course, COLORS[name])
        panels[panel].set_title(f"{NAMES[name]}, {seconds:.0f} s")
    for name, course in courses.items():
        panels["t"].plot(course.seconds, course.rmsd, color=COLORS[name], linewidth=0.8, label=NAMES[name])
    panels["t"].set(xlabel="CPU time, s", ylabel="backbone RMSD from the start, Å", xlim=0, ylim=0)
    panels["t"].set_ylim(top=1.25 * panels["t"].get_ylim()[1])
    panels["t"].legend(loc="upper left", frameon=False, ncols=2)
    _drawSizes(panels["b"], sizes)
    figure.savefig(options.picture, dpi=100)
    return 0


def _drawAngles(panel, course, color):
    phi, psi = (np.degrees(angles[course.kept]).ravel() for angles in (course.phi, course.psi))
    panel.scatter(phi, psi, s=1, alpha=min(1, 3e3 / len(phi)), color=color, linewidths=0, rasterized=True)
    ticks = range(-180, 181, 90)
    panel.set(xlabel="φ, °", ylabel="ψ, °", xlim=(-180, 180), ylim=(-180, 180), xticks=ticks, yticks=ticks, aspect=1)


def _drawSizes(panel, sizes):
    names = list(sizes["moves"])
    for offset, name in zip((-0.2, 0.2), COLORS, strict=True):
        bars = panel.barh(np.arange(len(names)) + offset, sizes[name].values(), 0.38, color=COLORS[name])
        panel.bar_label(bars, fmt="{:.0f}", padding=2)
    panel.set_xscale("log")
    panel.set(yticks=range(len(names)), yticklabels=names, title="Effective sample sizes")
    panel.set_xlim(1, 4 * max(max(one.values()) for one in sizes.values()))
    panel.invert_yaxis()


def main(arguments=None):
    """Run the script; return its exit status."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n", 1)[0])
    commands = parser.add_subparsers(required=True)
    running = commands.add_parser("run", help="run one method")
    running.add_argument("method", choices=["moves", "dynamics"])
    running.add_argument("structure", help="a PDB file")
    running.add_argument("output", help="the file to write (.npz)")
    running.add_argument("--seconds", type=float, default=300, help="of CPU time (default: 300)")
    running.add_argument("--seed", type=int, default=1)
    running.set_defaults(function=run)
    drawing = commands.add_parser("draw", help="draw two runs")
    for name, meaning in {"structure": "the PDB file", "moves": "a file of run", "dynamics": "a file of run"}.items():
        drawing.add_argument(name, help=meaning)
    drawing.add_argument("picture", help="the picture to write")
    drawing.set_defaults(function=draw)
    options = parser.parse_args(arguments)
    return options.function(options)


if __name__ == "__main__":
    sys.exit(main())
