"""The energies of a run: the parts of U, and OpenMM's own value."""

import openmm
from openmm import unit

from ..openmmchaintree import StericExclusionForce

_GROUPS = 32  # OpenMM's number of force groups


class Energies:
    """The energies that a run samples with.

    Attributes
    ----------
    model : EnergyModel
    plan : list of PlannedEnergy
        without the Forces that are not sampled
    """

    def __init__(self, model, integrator, context):
        """Take an integrator and its Context."""
        self.model = model
        self._integrator = integrator
        self._context = context
        self._reference = None
        self.plan = [entry for entry in integrator.getEnergyPlan(context) if entry.kind != "not sampled"]

    def held(self):
        """Return the integrator's U of the current positions, kJ/mol."""
        return self._integrator.getPotentialEnergy(self._context)

    def describeStages(self, counts):
        """Return a dictionary for each stage that has decided trials, from (decided, refused) of all stages."""
        names = [stage.stage for stage in self._integrator.getStageStatistics()]
        return [
            {"stage": name, "computed": computed, "refused": refused}
            for name, (computed, refused) in zip(names, counts, strict=bool(counts))
            if computed
        ]

    def outerTests(self):
        """Return the OuterStatistics, or None if there was no outer test."""
        statistics = self._integrator.getOuterStatistics()
        return statistics if statistics.attempted else None

    def byOpenMM(self, positions):
        """Return U at positions by OpenMM's Reference platform (kJ/mol), and a dictionary for each Force.

        It says how the energy of the Force in a trial is evaluated, and why; and that energy, or None if there are more
        Forces than OpenMM has groups.
        """
        if self._reference is None:
            self._reference = self._makeReference()
        context = self._reference
        context.setPositions(positions)
        groups = sorted({min(entry.force, _GROUPS - 1) for entry in self.plan})
        energies = {group: _energy(context, {group}) for group in groups}
        isDistinct = self._context.getSystem().getNumForces() <= _GROUPS
        parts = [
            {
                "name": entry.name,
                "kind": entry.kind,
                "reason": entry.reason,
                "energy": energies[entry.force] if isDistinct else None,
            }
            for entry in self.plan
        ]
        return sum(energies.values()), parts

    def _makeReference(self):
        """Make a Context of the sampled Forces, each in a separate group."""
        system = openmm.XmlSerializer.clone(self._context.getSystem())
        forces = list(system.getForces())
        for index, force in enumerate(forces):
            force.setForceGroup(min(index, _GROUPS - 1))
        sampled = {entry.force for entry in self.plan}
        for index in reversed(range(len(forces))):
            if index not in sampled or StericExclusionForce.isinstance(forces[index]):
                system.removeForce(index)
        return openmm.Context(system, openmm.VerletIntegrator(0.001), openmm.Platform.getPlatformByName("Reference"))


def _energy(context, groups):
    state = context.getState(energy=True, groups=groups)
    return state.getPotentialEnergy().value_in_unit(unit.kilojoule_per_mole)
