"""TorsionMonteCarloIntegrator as a move of openmmtools, which this module needs."""

from typing import Any

try:
    from openmmtools import mcmc
except ModuleNotFoundError as error:
    raise ModuleNotFoundError(
        "openmmchaintree.openmmtoolsmove needs openmmtools: pip install openmmtools", name=error.name
    ) from error

from .openmmchaintree import MoveStatistics, StericExclusionForce, TorsionMonteCarloIntegrator


class TorsionMonteCarloMove(mcmc.IntegratorMove):  # type: ignore[misc]
    """Steps of a TorsionMonteCarloIntegrator, at the temperature of the thermodynamic state.

    openmmtools exchanges replicas by the energy of all Forces, including the StericExclusionForce. Hard spheres have no
    energy in trials, so the two agree only without clashes. A state with clashes is an error, unless the integrator's
    steric mode is Soft. Use this mode in a SequenceMove with dynamics, too. Velocities turn with the links, which keeps
    the temperature; it is an error if a constraint does not allow that.

    Replicas in separate processes (MPI) need an integrator with the seed 0, so that each process draws another seed.

    Parameters
    ----------
    integrator : TorsionMonteCarloIntegrator
        with its moves; a copy of it is used
    n_steps : int
        the number of steps, of `setTrialsPerStep` trials each
    **kwargs
        as in openmmtools.mcmc.IntegratorMove

    Attributes
    ----------
    statistics : list of MoveStatistics
        the numbers of trials of each move of the integrator by their results, in all states together
    """

    def __init__(self, integrator: TorsionMonteCarloIntegrator, n_steps: int = 1, **kwargs: Any) -> None:
        if not isinstance(integrator, TorsionMonteCarloIntegrator):
            raise TypeError(
                f"TorsionMonteCarloMove takes a TorsionMonteCarloIntegrator, not {type(integrator).__name__}"
            )
        super().__init__(integrator, n_steps, **{"n_restart_attempts": 0, **kwargs})
        self._counts = [(0, 0, 0, 0)] * integrator.getNumMoves()

    @property
    def statistics(self) -> list[MoveStatistics]:
        return [MoveStatistics(*counts) for counts in self._counts]

    @statistics.setter
    def statistics(self, value: list[Any]) -> None:
        self._counts = [tuple(counts) for counts in value]

    def _get_integrator(self, thermodynamic_state):
        integrator = super()._get_integrator(thermodynamic_state)
        integrator.setTemperature(thermodynamic_state.temperature)
        return integrator

    def _before_integration(self, context, thermodynamic_state):
        integrator = context.getIntegrator()
        integrator.resetMoveStatistics()
        integrator.checkVelocities(context)
        mode = integrator.getStericModeInContext(context)
        if mode == integrator.Soft:
            return
        for force in context.getSystem().getForces():
            if StericExclusionForce.isinstance(force):
                _refuseEnergyOf(StericExclusionForce.cast(force), mode == integrator.Off, context)

    def _after_integration(self, context, thermodynamic_state):
        integrator = context.getIntegrator()
        self._counts = [
            tuple(sum(pair) for pair in zip(counts, integrator.getMoveStatistics(move), strict=True))
            for move, counts in enumerate(self._counts)
        ]

    def __getstate__(self):
        return {**super().__getstate__(), "counts": [list(counts) for counts in self._counts]}

    def __setstate__(self, serialization):
        super().__setstate__(serialization)
        self.integrator = TorsionMonteCarloIntegrator.cast(self.integrator)
        self.statistics = serialization["counts"]


def _refuseEnergyOf(force, isOff, context):
    """Raise a ValueError if openmmtools exchanges replicas by an energy of the spheres that trials ignore."""
    if isOff:
        if force.getForceConstant()._value > 0:
            raise ValueError(
                "TorsionMonteCarloMove: trials ignore the spheres, but openmmtools gives them an energy: call "
                "setForceConstant(0) of the StericExclusionForce before its System becomes a state, or "
                "setStericMode(integrator.Hard)"
            )
        return
    count = len(force.getClashes(context)[0])
    if count > 0:
        raise ValueError(
            f"TorsionMonteCarloMove: {count} pairs of atoms clash: openmmtools gives them an energy, hard spheres "
            "none. Relax the positions, or call setStericMode(integrator.Soft)"
        )
