"""The settings of a run that samples an energy, whatever the source of its System."""

from openmm import app, unit

from ..errors import InputError

# Nonbonded methods of OpenMM that need a periodic box.
PERIODIC_METHODS = ("CutoffPeriodic", "Ewald", "PME", "LJPME")


class EnergySettings:
    """The temperature and options of a run, and arguments for createSystem.

    Attributes
    ----------
    files : list of str
        the files that define the energy, as the user named them
    temperature : float, K
    cutoff : float or None, nm
    trialsPerOuterTest : int
        as in TorsionMonteCarloIntegrator, 0 by default
    areNative : bool
        whether openmm-chaintree evaluates the Forces that it can
    steric : str or None
        the steric mode; None: the default for the System
    isFlexible : bool
        whether bond lengths and angles change
    periodicMethod : str
        one of PERIODIC_METHODS, for a System in a periodic box
    """

    def __init__(
        self,
        files,
        temperature,
        cutoff=None,
        trialsPerOuterTest=0,
        areNative=True,
        steric=None,
        isFlexible=False,
        periodicMethod=PERIODIC_METHODS[0],
    ):
        """Keep the settings."""
        self.files = list(files)
        self.temperature = temperature
        self.cutoff = cutoff
        self.trialsPerOuterTest = trialsPerOuterTest
        self.areNative = areNative
        self.steric = steric
        self.isFlexible = isFlexible
        self.periodicMethod = periodicMethod

    def describe(self, files, pairs=None):
        """Return a line on the energy; pairs describes the choice of pairs, by default the cutoff."""
        if pairs is None:
            pairs = "no cutoff" if self.cutoff is None else f"pairs up to {self.cutoff:g} nm"
        flexible = ", flexible" if self.isFlexible else ""
        return f"{files} at {self.temperature:g} K, {pairs}{flexible}"

    def checkPeriodic(self):
        """Raise an InputError if this energy cannot be sampled in a periodic box."""
        if self.cutoff is None:
            raise InputError("--periodic needs --nonbonded-cutoff in a force field")

    def argumentsOf(self, topology, cutoff):
        """Return arguments of createSystem for a Topology with or without a box, and a cutoff in nm or None."""
        method = app.NoCutoff
        if cutoff is not None:
            isPeriodic = topology.getPeriodicBoxVectors() is not None
            method = getattr(app, self.periodicMethod) if isPeriodic else app.CutoffNonPeriodic
        return {
            "nonbondedMethod": method,
            "nonbondedCutoff": (1.0 if cutoff is None else cutoff) * unit.nanometer,
            "rigidWater": False,
            "removeCMMotion": False,
        }
