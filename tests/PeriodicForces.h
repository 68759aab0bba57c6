#ifndef OPENMM_CHAINTREE_PERIODICFORCES_H_
#define OPENMM_CHAINTREE_PERIODICFORCES_H_

/**
 * Common code of the tests of native energies in periodic boxes: boxes, chains in them, and Forces of each kind, with
 * their energies by sums over all images.
 */

#include "openmm/CMAPTorsionForce.h"
#include "openmm/CustomAngleForce.h"
#include "openmm/CustomBondForce.h"
#include "openmm/CustomCentroidBondForce.h"
#include "openmm/CustomCompoundBondForce.h"
#include "openmm/CustomExternalForce.h"
#include "openmm/CustomGBForce.h"
#include "openmm/CustomNonbondedForce.h"
#include "openmm/CustomTorsionForce.h"
#include "openmm/GBSAOBCForce.h"
#include "openmm/HarmonicAngleForce.h"
#include "openmm/HarmonicBondForce.h"
#include "openmm/internal/NonbondedForceImpl.h"
#include "openmm/NonbondedForce.h"
#include "openmm/PeriodicTorsionForce.h"
#include "openmm/RBTorsionForce.h"
#include "openmm/TabulatedFunction.h"
#include "SamplingSupport.h"
#include <array>
#include <numeric>
#include <random>

typedef array<Vec3, 3> Box;

struct NamedBox {
    string name;
    Box vectors;
};

/** The last but one is at the edge of OpenMM's reduced form; in the last one chains meet themselves. */
static const vector<NamedBox> BOXES = {
    {"cube", {{Vec3(5, 0, 0), Vec3(0, 5, 0), Vec3(0, 0, 5)}}},
    {"flat", {{Vec3(6, 0, 0), Vec3(0, 5, 0), Vec3(0, 0, 3)}}},
    {"slab", {{Vec3(3, 0, 0), Vec3(0, 3, 0), Vec3(0, 0, 20)}}},
    {"octahedron",
     {{Vec3(5, 0, 0), Vec3(5 / 3.0, 4.714045207910317, 0), Vec3(-5 / 3.0, 2.3570226039551585, 4.08248290463863)}}},
    {"dodecahedron", {{Vec3(5, 0, 0), Vec3(0, 5, 0), Vec3(2.5, 2.5, 3.5355339059327378)}}},
    {"skewed", {{Vec3(4, 0, 0), Vec3(1.3, 4.4, 0), Vec3(-1.1, 0.9, 5)}}},
    {"edge", {{Vec3(4, 0, 0), Vec3(2, 4, 0), Vec3(-2, 2, 4)}}},
    {"small", {{Vec3(1.65, 0, 0), Vec3(0, 1.65, 0), Vec3(0, 0, 1.65)}}},
};

static bool isRectangular(const Box& box)
{
    return box[1][0] == 0 && box[2][0] == 0 && box[2][1] == 0;
}

static double getWidth(const Box& box)
{
    return min(box[0][0], min(box[1][1], box[2][2]));
}

/**
 * Get the difference of two positions as OpenMM reduces it. It is the least image up to half the width of the box.
 */
static Vec3 reduce(Vec3 apart, const Box& box)
{
    for (int i = 2; i >= 0; i--)
        apart -= box[i] * floor(apart[i] / box[i][i] + 0.5);
    return apart;
}

static const int LENGTH = 6, NUM_CHAINS = 7, NUM_BEADS = LENGTH * NUM_CHAINS;

/**
 * Chains in a periodic box.
 */
class PeriodicChains : public BeadChain {
public:
    explicit PeriodicChains(const Box& box, bool spheresArePeriodic = true) :
        BeadChain(LENGTH, 0.05, 1.0), width(getWidth(box))
    {
        system.setDefaultPeriodicBoxVectors(box[0], box[1], box[2]);
        force->setUsesPeriodicBoundaryConditions(spheresArePeriodic);
        mt19937 random(3);
        uniform_real_distribution<double> uniform(-3, 3);
        for (int chain = 1; chain < NUM_CHAINS; chain++)
            addMolecule(LENGTH, 0.05, 1.0 + chain, Vec3(uniform(random), uniform(random), uniform(random)));
    }
    const double width;
};

/** Whether a pair of beads, the first of which has the lower index, has an exception or exclusion in Forces of pairs.
 */
static bool areExcluded(int i, int j)
{
    return j - i <= 2 && i / LENGTH == j / LENGTH;
}

static double getCharge(int bead)
{
    return bead % 2 == 0 ? 0.08 : -0.06;
}

/** A parameter of beads in expressions. */
static double getValue(int bead)
{
    return 0.2 + 0.1 * (bead % 4);
}

static double getSigma(int bead)
{
    return 0.1 + 0.01 * (bead % 3);
}

static double computeLennardJones(double r, double sigma, double epsilon)
{
    const double sixth = pow(sigma / r, 6);
    return 4 * epsilon * (sixth * sixth - sixth);
}

static double computeSwitch(double r, double from, double to)
{
    const double t = max(0.0, (r - from) / (to - from));
    return 1 + t * t * t * (-10 + t * (15 - 6 * t));
}

static const double COULOMB = 138.93545764438198;

/**
 * A kind of Force with periodic boundary conditions.
 */
struct PeriodicKind {
    string name;
    /** Make one for chains in a box of a width. */
    function<Force*(double width)> make;
    /** Compute the energy of two beads at a distance within the cutoff, if the Force is one of pairs. */
    function<double(double width, int i, int j, double r)> computePair = nullptr;
    /** The cutoff of a Force of pairs as a part of the width of the box. */
    double cutoff = 0;
    /** Compute the energy of two beads without the switch and at any distance, if there is a long-range correction. */
    function<double(double width, int i, int j, double r)> computeWhole = nullptr;
    /** Whether a bead interacts with images of itself in the long-range correction. */
    bool hasSelf = true;
    /** Compute the energy by nearest images, and the sum of the magnitudes of its parts, if it is one of values. */
    function<double(const vector<Vec3>& x, const Box& box, double width, double& size)> computeValues = nullptr;
    /** Make a Force that is needed beside it, whose energy is included in that of values. */
    function<Force*(double width)> makePartner = nullptr;
    /** Whether it has no energy in boxes that are not rectangular. */
    bool needsRectangle = false;
    /** Get whether OpenMM's lists of neighbors decide which pairs count. */
    bool hasPairs() const
    {
        return computePair || computeValues;
    }
};

// ---- Lennard-Jones and charges ----

static NonbondedForce* makeNonbonded(double cutoff)
{
    NonbondedForce* force = new NonbondedForce();
    for (int i = 0; i < NUM_BEADS; i++) {
        force->addParticle(getCharge(i), getSigma(i), 0.5);
        for (int j = 0; j < i; j++)
            if (areExcluded(j, i))
                force->addException(j, i, 0, 0.1, 0);
    }
    force->setNonbondedMethod(NonbondedForce::CutoffPeriodic);
    force->setCutoffDistance(cutoff);
    force->setUseDispersionCorrection(false);
    return force;
}

/** Exceptions with an energy, of beads that are at most two bonds apart and of distant ones. */
static NonbondedForce* makeExceptions(double width, bool arePeriodic)
{
    NonbondedForce* force = makeNonbonded(0.5 * width);
    for (int i = 0; i < force->getNumExceptions(); i += 2) {
        int p1, p2;
        double charges, sigma, epsilon;
        force->getExceptionParameters(i, p1, p2, charges, sigma, epsilon);
        force->setExceptionParameters(i, p1, p2, 0.05, 0.1, 0.2);
    }
    force->setExceptionsUsePeriodicBoundaryConditions(arePeriodic);
    return force;
}

static double computeReactionField(int i, int j, double r, double cutoff)
{
    const double dielectric = 78.3, k = (dielectric - 1) / (2 * dielectric + 1) / pow(cutoff, 3);
    const double c = 3 * dielectric / (2 * dielectric + 1) / cutoff;
    return COULOMB * getCharge(i) * getCharge(j) * (1 / r + k * r * r - c);
}

static double computeNonbonded(double width, int i, int j, double r)
{
    return computeLennardJones(r, (getSigma(i) + getSigma(j)) / 2, 0.5) + computeReactionField(i, j, r, 0.5 * width);
}

static const double SWITCHED_FROM = 0.35;

static const vector<PeriodicKind> NONBONDED_KINDS = {
    {"NonbondedForce",
     [](double width) {
         return makeNonbonded(0.5 * width);
     },
     computeNonbonded, 0.5},
    {"NonbondedForce, switched",
     [](double width) {
         NonbondedForce* force = makeNonbonded(0.499 * width);
         force->setUseSwitchingFunction(true);
         force->setSwitchingDistance(SWITCHED_FROM * width);
         return force;
     },
     [](double width, int i, int j, double r) {
         return computeLennardJones(r, (getSigma(i) + getSigma(j)) / 2, 0.5) *
                    computeSwitch(r, SWITCHED_FROM * width, 0.499 * width) +
                computeReactionField(i, j, r, 0.499 * width);
     },
     0.499},
    {"NonbondedForce, dispersion correction",
     [](double width) {
         NonbondedForce* force = makeNonbonded(0.5 * width);
         force->setUseDispersionCorrection(true);
         return force;
     },
     computeNonbonded, 0.5},
    {"NonbondedForce, exceptions",
     [](double width) {
         return makeExceptions(width, false);
     },
     computeNonbonded, 0.5},
    {"NonbondedForce, periodic exceptions",
     [](double width) {
         return makeExceptions(width, true);
     },
     computeNonbonded, 0.5},
};

// ---- Ewald summation ----

static const double EWALD_TOLERANCE = 1e-3;

/** Get alpha in a box of a width: with Ewald summation that of OpenMM. */
static double getAlpha(double width)
{
    return sqrt(-log(2 * EWALD_TOLERANCE)) / (0.499 * width);
}

static NonbondedForce* makeEwald(double width, NonbondedForce::NonbondedMethod method, bool exceptionsArePeriodic)
{
    NonbondedForce* force = makeExceptions(width, exceptionsArePeriodic);
    force->setNonbondedMethod(method);
    force->setCutoffDistance(0.499 * width);
    force->setEwaldErrorTolerance(EWALD_TOLERANCE);
    force->setPMEParameters(getAlpha(width), 20, 24, 30); // sizes that all platforms use
    force->setUseDispersionCorrection(true);
    return force;
}

static double computeDirectSpace(double width, int i, int j, double r)
{
    return computeLennardJones(r, (getSigma(i) + getSigma(j)) / 2, 0.5) +
           COULOMB * getCharge(i) * getCharge(j) * erfc(getAlpha(width) * r) / r;
}

static const vector<PeriodicKind> EWALD_KINDS = {
    {"NonbondedForce, PME",
     [](double width) {
         return makeEwald(width, NonbondedForce::PME, false);
     },
     computeDirectSpace, 0.499},
    {"NonbondedForce, PME, switched",
     [](double width) {
         NonbondedForce* force = makeEwald(width, NonbondedForce::PME, true);
         force->setUseSwitchingFunction(true);
         force->setSwitchingDistance(SWITCHED_FROM * width);
         return force;
     },
     [](double width, int i, int j, double r) {
         const double lennardJones = computeLennardJones(r, (getSigma(i) + getSigma(j)) / 2, 0.5);
         return computeDirectSpace(width, i, j, r) +
                lennardJones * (computeSwitch(r, SWITCHED_FROM * width, 0.499 * width) - 1);
     },
     0.499},
    {"NonbondedForce, Ewald",
     [](double width) {
         return makeEwald(width, NonbondedForce::Ewald, true);
     },
     computeDirectSpace, 0.499, nullptr, true, nullptr, nullptr, true},
};

static bool isEwald(const NonbondedForce& force)
{
    return force.getNonbondedMethod() == NonbondedForce::PME || force.getNonbondedMethod() == NonbondedForce::Ewald;
}

/**
 * Sum what a NonbondedForce has beside its pairs. Of Ewald summation this is direct space.
 *
 * @param size  the sum of magnitudes, to which this adds
 */
static double sumBesidePairs(const NonbondedForce& force, const System& system, const vector<Vec3>& x, const Box& box,
                             double width, double& size)
{
    double energy = 0;
    if (force.getUseDispersionCorrection())
        energy = NonbondedForceImpl::calcDispersionCorrection(system, force) / (box[0][0] * box[1][1] * box[2][2]);
    for (int i = 0; i < force.getNumExceptions(); i++) {
        int p1, p2;
        double charges, sigma, epsilon;
        force.getExceptionParameters(i, p1, p2, charges, sigma, epsilon);
        Vec3 apart = x[p1] - x[p2];
        if (force.getExceptionsUsePeriodicBoundaryConditions())
            apart = reduce(apart, box);
        const double r = sqrt(apart.dot(apart));
        double ofPair = computeLennardJones(r, sigma, epsilon) + COULOMB * charges / r;
        if (isEwald(force))
            ofPair -= COULOMB * getCharge(p1) * getCharge(p2) * erf(getAlpha(width) * r) / r;
        energy += ofPair;
        size += fabs(ofPair);
    }
    return energy;
}

// ---- Expressions of pairs ----

/**
 * Add the beads, each with a parameter, and their exclusions to a Force of pairs.
 */
template <class PairForce>
static void addBeads(PairForce& force)
{
    force.addPerParticleParameter("a");
    for (int i = 0; i < NUM_BEADS; i++) {
        force.addParticle({getValue(i)});
        for (int j = 0; j < i; j++)
            if (areExcluded(j, i))
                force.addExclusion(j, i);
    }
}

static CustomNonbondedForce* makeCustomNonbonded(const string& expression, double cutoff)
{
    CustomNonbondedForce* force = new CustomNonbondedForce(expression);
    addBeads(*force);
    force->setNonbondedMethod(CustomNonbondedForce::CutoffPeriodic);
    force->setCutoffDistance(cutoff);
    return force;
}

static double computeExponential(double, int i, int j, double r)
{
    return 1.5 * getValue(i) * getValue(j) * exp(-2 * r);
}

static const string EXPONENTIAL = "1.5*a1*a2*exp(-2*r)";

/** Beads of the first set of an interaction group, whose second set holds all beads. */
static bool isInFirstSet(int bead)
{
    return bead % 3 != 0;
}

static CustomNonbondedForce* makeGroups(const string& expression, double cutoff)
{
    CustomNonbondedForce* force = makeCustomNonbonded(expression, cutoff);
    set<int> some, all;
    for (int i = 0; i < NUM_BEADS; i++) {
        all.insert(i);
        if (isInFirstSet(i))
            some.insert(i);
    }
    force->addInteractionGroup(some, all);
    return force;
}

static double computeSlowDecay(double, int i, int j, double r)
{
    return 0.01 * getValue(i) * getValue(j) / pow(r * r + 0.1, 3);
}

static const string SLOW_DECAY = "0.01*a1*a2/(r^2+0.1)^3";

static double computeSlowDecayOfGroups(double width, int i, int j, double r)
{
    return isInFirstSet(i) || isInFirstSet(j) ? computeSlowDecay(width, i, j, r) : 0;
}

static const vector<PeriodicKind> EXPRESSION_KINDS = {
    {"CustomNonbondedForce",
     [](double width) {
         return makeCustomNonbonded(EXPONENTIAL, 0.5 * width);
     },
     computeExponential, 0.5},
    {"CustomNonbondedForce, switched",
     [](double width) {
         CustomNonbondedForce* force = makeCustomNonbonded(EXPONENTIAL, 0.4 * width);
         force->setUseSwitchingFunction(true);
         force->setSwitchingDistance(0.2 * width);
         return force;
     },
     [](double width, int i, int j, double r) {
         return computeExponential(width, i, j, r) * computeSwitch(r, 0.2 * width, 0.4 * width);
     },
     0.4},
    {"CustomNonbondedForce, long-range",
     [](double width) {
         CustomNonbondedForce* force = makeCustomNonbonded(SLOW_DECAY, 0.5 * width);
         force->setUseLongRangeCorrection(true);
         return force;
     },
     computeSlowDecay, 0.5, computeSlowDecay},
    {"CustomNonbondedForce, long-range, switched",
     [](double width) {
         CustomNonbondedForce* force = makeCustomNonbonded(SLOW_DECAY, 0.4 * width);
         force->setUseSwitchingFunction(true);
         force->setSwitchingDistance(0.2 * width);
         force->setUseLongRangeCorrection(true);
         return force;
     },
     [](double width, int i, int j, double r) {
         return computeSlowDecay(width, i, j, r) * computeSwitch(r, 0.2 * width, 0.4 * width);
     },
     0.4, computeSlowDecay},
    {"CustomNonbondedForce, long-range, groups",
     [](double width) {
         CustomNonbondedForce* force = makeGroups(SLOW_DECAY, 0.4 * width);
         force->setUseLongRangeCorrection(true);
         return force;
     },
     computeSlowDecayOfGroups, 0.4, computeSlowDecayOfGroups, false},
    {"CustomNonbondedForce, groups",
     [](double width) {
         return makeGroups(EXPONENTIAL, 0.4 * width);
     },
     [](double width, int i, int j, double r) {
         return isInFirstSet(i) || isInFirstSet(j) ? computeExponential(width, i, j, r) : 0;
     },
     0.4},
    {"CustomNonbondedForce, table",
     [](double width) {
         CustomNonbondedForce* force = makeCustomNonbonded("a1*a2*square(r)", 0.5 * width);
         vector<double> line;
         for (int i = 0; i <= 8; i++)
             line.push_back(3 * i / 8.0 - 1);
         force->addTabulatedFunction("square", new Continuous1DFunction(line, 0, 3));
         return force;
     },
     [](double, int i, int j, double r) {
         return getValue(i) * getValue(j) * (r - 1);
     },
     0.5},
    {"CustomNonbondedForce, computed values",
     [](double width) {
         CustomNonbondedForce* force = makeCustomNonbonded("(b1+b2)/(1+r^2)", 0.5 * width);
         force->addComputedValue("b", "a^2");
         return force;
     },
     [](double, int i, int j, double r) {
         return (getValue(i) * getValue(i) + getValue(j) * getValue(j)) / (1 + r * r);
     },
     0.5},
};

/**
 * Sum the energies of all pairs in all images of a box.
 *
 * @param size  on exit, the sum of their magnitudes
 */
static double sumPairs(const PeriodicKind& kind, const vector<Vec3>& x, const Box& box, double width, double& size)
{
    double energy = 0;
    size = 0;
    for (int j = 0; j < NUM_BEADS; j++)
        for (int i = 0; i < j; i++) {
            if (areExcluded(i, j))
                continue;
            const Vec3 middle = reduce(x[i] - x[j], box);
            for (int n = 0; n < 125; n++) {
                const Vec3 image = middle + box[0] * (n % 5 - 2) + box[1] * (n / 5 % 5 - 2) + box[2] * (n / 25 - 2);
                const double r = sqrt(image.dot(image));
                if (r >= kind.cutoff * width)
                    continue;
                const double ofPair = kind.computePair(width, i, j, r);
                energy += ofPair;
                size += fabs(ofPair);
            }
        }
    return energy;
}

/**
 * Compute the long-range correction times the volume of the box: the integral over all space of the energy that pairs,
 * excluded or not, do not have because of the cutoff and the switch, at the mean density.
 */
static double integrateLongRange(const PeriodicKind& kind, double width)
{
    const int numSteps = 100;
    const double cutoff = kind.cutoff * width, begin = 0.2 * width, step = (cutoff - begin) / numSteps;
    double sum = 0;
    for (int j = 0; j < NUM_BEADS; j++)
        for (int i = 0; i <= (kind.hasSelf ? j : j - 1); i++)
            for (int k = 0; k <= numSteps; k++) { // Simpson's rule, over the cutoff divided by the distance beyond it
                const double weight = (k == 0 || k == numSteps ? 1 : k % 2 == 1 ? 4 : 2) / 3.0;
                const double r = begin + k * step, u = max((double)k / numSteps, 1e-9);
                const double lost = kind.computeWhole(width, i, j, r) - kind.computePair(width, i, j, r);
                sum += lost * r * r * weight * step +
                       kind.computeWhole(width, i, j, cutoff / u) * pow(cutoff, 3) / pow(u, 4) * weight / numSteps;
            }
    return 4 * M_PI * sum * NUM_BEADS / (NUM_BEADS + 1);
}

// ---- Values ----

static Force* makeValues(double width)
{
    CustomGBForce* force = new CustomGBForce();
    addBeads(*force);
    force->addComputedValue("I", "a2*exp(-2*r)", CustomGBForce::ParticlePair);
    force->addComputedValue("V", "a+1/(1+I^2)", CustomGBForce::SingleParticle);
    force->addEnergyTerm("3*a*V", CustomGBForce::SingleParticle);
    force->addEnergyTerm("V1*V2*exp(-3*r)", CustomGBForce::ParticlePairNoExclusions);
    force->addEnergyTerm("0.3*V1*V2/(0.5+r)", CustomGBForce::ParticlePair);
    force->setNonbondedMethod(CustomGBForce::CutoffPeriodic);
    force->setCutoffDistance(0.45 * width);
    return force;
}

/**
 * Call a function for all pairs whose nearest images are within a cutoff.
 */
static void forEachNearPair(const vector<Vec3>& x, const Box& box, double cutoff,
                            function<void(int i, int j, double r)> add)
{
    for (int j = 0; j < NUM_BEADS; j++)
        for (int i = 0; i < j; i++) {
            const Vec3 apart = reduce(x[i] - x[j], box);
            const double r = sqrt(apart.dot(apart));
            if (r < cutoff)
                add(i, j, r);
        }
}

static double computeValues(const vector<Vec3>& x, const Box& box, double width, double& size)
{
    vector<double> sums(NUM_BEADS), values;
    forEachNearPair(x, box, 0.45 * width, [&](int i, int j, double r) {
        sums[i] += areExcluded(i, j) ? 0 : getValue(j) * exp(-2 * r);
        sums[j] += areExcluded(i, j) ? 0 : getValue(i) * exp(-2 * r);
    });
    double energy = 0;
    for (int i = 0; i < NUM_BEADS; i++) {
        values.push_back(getValue(i) + 1 / (1 + sums[i] * sums[i]));
        energy += 3 * getValue(i) * values[i];
    }
    forEachNearPair(x, box, 0.45 * width, [&](int i, int j, double r) {
        energy += values[i] * values[j] * (exp(-3 * r) + (areExcluded(i, j) ? 0 : 0.3 / (0.5 + r)));
    });
    size = energy; // all of its parts are positive
    return energy;
}

// ---- Generalized Born ----

static double getBornRadius(int bead)
{
    return 0.15 + 0.01 * (bead % 5);
}

static const double BORN_OFFSET = 0.009, BORN_SCALE = 0.8, SOLVENT_DIELECTRIC = 78.5, BORN_CUTOFF = 0.45;

static Force* makeGBSAOBC(double width)
{
    GBSAOBCForce* force = new GBSAOBCForce();
    for (int i = 0; i < NUM_BEADS; i++)
        force->addParticle(getCharge(i), getBornRadius(i), BORN_SCALE);
    force->setSolventDielectric(SOLVENT_DIELECTRIC);
    force->setSurfaceAreaEnergy(0);
    force->setNonbondedMethod(GBSAOBCForce::CutoffPeriodic);
    force->setCutoffDistance(BORN_CUTOFF * width);
    return force;
}

static Force* makeCustomBorn(double width)
{
    CustomGBForce* force = new CustomGBForce();
    for (const char* name : {"charge", "or", "sr"})
        force->addPerParticleParameter(name);
    for (int i = 0; i < NUM_BEADS; i++) {
        const double offsetRadius = getBornRadius(i) - BORN_OFFSET;
        force->addParticle({getCharge(i), offsetRadius, BORN_SCALE * offsetRadius});
    }
    force->addComputedValue("I",
                            "select(step(r+sr2-or1), 0.5*(1/L-1/U+0.25*(r-sr2^2/r)*(1/(U^2)-1/(L^2))+"
                            "0.5*log(L/U)/r), 0); U=r+sr2; L=max(or1, D); D=abs(r-sr2)",
                            CustomGBForce::ParticlePairNoExclusions);
    force->addComputedValue("B",
                            "1/(1/or-tanh(psi-0.8*psi^2+4.85*psi^3)/radius); psi=I*or; radius=or+offset; offset=0.009",
                            CustomGBForce::SingleParticle);
    force->addEnergyTerm("-0.5*138.93545764438198*(1-1/78.5)*charge^2/B", CustomGBForce::SingleParticle);
    force->addEnergyTerm("-138.93545764438198*(1-1/78.5)*charge1*charge2/f; f=sqrt(r^2+B1*B2*exp(-r^2/(4*B1*B2)))",
                         CustomGBForce::ParticlePairNoExclusions);
    force->setNonbondedMethod(CustomGBForce::CutoffPeriodic);
    force->setCutoffDistance(BORN_CUTOFF * width);
    return force;
}

/**
 * Compute what a sphere at a distance contributes to the Born sum of another bead.
 */
static double computeBornPart(int i, int j, double r, bool isFilled)
{
    const double o = getBornRadius(i) - BORN_OFFSET, s = BORN_SCALE * (getBornRadius(j) - BORN_OFFSET);
    if (r + s < o)
        return 0;
    const double upper = r + s, lower = max(o, fabs(r - s));
    const double part = 1 / lower - 1 / upper + 0.25 * (r - s * s / r) * (1 / (upper * upper) - 1 / (lower * lower)) +
                        0.5 * log(lower / upper) / r;
    return 0.5 * part + (isFilled && o < s - r ? 1 / o - 1 / lower : 0);
}

/**
 * Compute the energy of generalized Born, and of the NonbondedForce beside it.
 *
 * @param isGBSAOBC  whether spheres within others are filled and the energy of a pair is shifted at the cutoff
 */
static double computeBorn(const vector<Vec3>& x, const Box& box, double width, double& size, bool isGBSAOBC)
{
    const double cutoff = BORN_CUTOFF * width, factor = -COULOMB * (1 - 1 / SOLVENT_DIELECTRIC);
    vector<double> sums(NUM_BEADS), radii;
    forEachNearPair(x, box, cutoff, [&](int i, int j, double r) {
        sums[i] += computeBornPart(i, j, r, isGBSAOBC);
        sums[j] += computeBornPart(j, i, r, isGBSAOBC);
    });
    double energy = sumPairs(NONBONDED_KINDS[0], x, box, width, size);
    auto add = [&](double part) {
        energy += part;
        size += fabs(part);
    };
    for (int i = 0; i < NUM_BEADS; i++) {
        const double o = getBornRadius(i) - BORN_OFFSET, p = sums[i] * o;
        radii.push_back(1 / (1 / o - tanh(p - 0.8 * p * p + 4.85 * p * p * p) / getBornRadius(i)));
        add(0.5 * factor * getCharge(i) * getCharge(i) / radii[i]);
    }
    forEachNearPair(x, box, cutoff, [&](int i, int j, double r) {
        const double product = radii[i] * radii[j], f = sqrt(r * r + product * exp(-r * r / (4 * product)));
        add(factor * getCharge(i) * getCharge(j) * (1 / f - (isGBSAOBC ? 1 / cutoff : 0)));
    });
    return energy;
}

static const vector<PeriodicKind> VALUE_KINDS = {
    {"CustomGBForce", makeValues, nullptr, 0, nullptr, true, computeValues},
    {"CustomGBForce, generalized Born", makeCustomBorn, nullptr, 0, nullptr, true,
     [](const vector<Vec3>& x, const Box& box, double width, double& size) {
         return computeBorn(x, box, width, size, false);
     },
     NONBONDED_KINDS[0].make},
    {"GBSAOBCForce", makeGBSAOBC, nullptr, 0, nullptr, true,
     [](const vector<Vec3>& x, const Box& box, double width, double& size) {
         return computeBorn(x, box, width, size, true);
     },
     NONBONDED_KINDS[0].make},
};

// ---- Terms ----

/**
 * Get the particles of a term: some terms are of one chain and most are of two.
 */
static vector<int> getTerm(int first, int size)
{
    vector<int> particles;
    for (int step : {0, 4, 1, 3})
        if ((int)particles.size() < size)
            particles.push_back((first + step) % NUM_BEADS);
    return particles;
}

/**
 * Make a Force of terms by adding each of them.
 */
template <class TermForce>
static TermForce* makeTerms(TermForce* force, int size, function<void(TermForce&, const vector<int>&)> addTerm)
{
    for (int i = 0; i < NUM_BEADS; i++)
        addTerm(*force, getTerm(i, size));
    force->setUsesPeriodicBoundaryConditions(true);
    return force;
}

static Force* makeMaps(double)
{
    CMAPTorsionForce* force = new CMAPTorsionForce();
    vector<double> energies;
    for (int i = 0; i < 36; i++)
        energies.push_back(sin(1.7 * i));
    force->addMap(6, energies);
    for (int i = 0; i < NUM_BEADS; i++) {
        const vector<int> p = getTerm(i, 4), q = getTerm(i + 2, 4);
        force->addTorsion(0, p[0], p[1], p[2], p[3], q[0], q[1], q[2], q[3]);
    }
    force->setUsesPeriodicBoundaryConditions(true);
    return force;
}

static Force* makeCentroidBonds(double)
{
    CustomCentroidBondForce* force = new CustomCentroidBondForce(3, "0.2*distance(g1,g2)*angle(g1,g2,g3)");
    for (int chain = 0; chain < NUM_CHAINS; chain++) {
        vector<int> beads(LENGTH);
        iota(beads.begin(), beads.end(), chain * LENGTH);
        force->addGroup({beads.begin(), beads.begin() + 3});
        force->addGroup({beads.begin() + 2, beads.end()}, {1, 2, 0.5, 1});
    }
    for (int i = 0; i < 2 * NUM_CHAINS; i++)
        force->addBond({i, (i + 3) % (2 * NUM_CHAINS), (i + 1) % (2 * NUM_CHAINS)});
    force->setUsesPeriodicBoundaryConditions(true);
    return force;
}

/** Groups of particles of two chains. */
static Force* makeCentroidsOfTwoChains(bool isPeriodic)
{
    CustomCentroidBondForce* force = new CustomCentroidBondForce(2, "0.02*distance(g1,g2)^2");
    for (int i = 0; i < NUM_BEADS; i++)
        force->addGroup(getTerm(i, 4), {1, 2, 0.5, 1});
    for (int i = 0; i < NUM_BEADS; i++)
        force->addBond({i, (i + LENGTH) % NUM_BEADS});
    force->setUsesPeriodicBoundaryConditions(isPeriodic);
    return force;
}

static Force* makePlaces(const string& expression)
{
    CustomExternalForce* force = new CustomExternalForce(expression);
    force->addPerParticleParameter("a");
    force->addPerParticleParameter("b");
    for (int i = 0; i < NUM_BEADS; i++)
        force->addParticle(i, {0.3 * i - 2, 1 - 0.2 * i});
    return force;
}

static const vector<PeriodicKind> TERM_KINDS = {
    {"HarmonicBondForce",
     [](double) {
         return makeTerms<HarmonicBondForce>(new HarmonicBondForce(), 2, [](HarmonicBondForce& force, auto& p) {
             force.addBond(p[0], p[1], 0.9, 3);
         });
     }},
    {"HarmonicBondForce, not periodic",
     [](double) {
         HarmonicBondForce* force = new HarmonicBondForce();
         for (int i = 0; i < NUM_BEADS; i++)
             force->addBond(getTerm(i, 2)[0], getTerm(i, 2)[1], 0.9, 0.03);
         return force;
     }},
    {"HarmonicAngleForce",
     [](double) {
         return makeTerms<HarmonicAngleForce>(new HarmonicAngleForce(), 3, [](HarmonicAngleForce& force, auto& p) {
             force.addAngle(p[0], p[1], p[2], 1.5, 3);
         });
     }},
    {"PeriodicTorsionForce",
     [](double) {
         return makeTerms<PeriodicTorsionForce>(new PeriodicTorsionForce(), 4,
                                                [](PeriodicTorsionForce& force, auto& p) {
                                                    force.addTorsion(p[0], p[1], p[2], p[3], 2, 0.3, 1);
                                                });
     }},
    {"RBTorsionForce",
     [](double) {
         return makeTerms<RBTorsionForce>(new RBTorsionForce(), 4, [](RBTorsionForce& force, auto& p) {
             force.addTorsion(p[0], p[1], p[2], p[3], 1, 0.5, -1, 0.3, 0, 0.1);
         });
     }},
    {"CMAPTorsionForce", makeMaps},
    {"CustomBondForce",
     [](double) {
         return makeTerms<CustomBondForce>(new CustomBondForce("0.1*(r-1)^2"), 2, [](CustomBondForce& force, auto& p) {
             force.addBond(p[0], p[1]);
         });
     }},
    {"CustomAngleForce",
     [](double) {
         return makeTerms<CustomAngleForce>(new CustomAngleForce("2*cos(3*theta)"), 3,
                                            [](CustomAngleForce& force, auto& p) {
                                                force.addAngle(p[0], p[1], p[2]);
                                            });
     }},
    {"CustomTorsionForce",
     [](double) {
         return makeTerms<CustomTorsionForce>(new CustomTorsionForce("2*cos(3*theta)"), 4,
                                              [](CustomTorsionForce& force, auto& p) {
                                                  force.addTorsion(p[0], p[1], p[2], p[3]);
                                              });
     }},
    {"CustomCompoundBondForce",
     [](double) {
         return makeTerms<CustomCompoundBondForce>(
             new CustomCompoundBondForce(4, "0.2*distance(p1,p3)*angle(p1,p2,p3)+0.2*dihedral(p1,p2,p3,p4)^2"), 4,
             [](CustomCompoundBondForce& force, auto& p) {
                 force.addBond(p);
             });
     }},
    {"CustomCompoundBondForce, points",
     [](double) {
         return makeTerms<CustomCompoundBondForce>(new CustomCompoundBondForce(2, "pointdistance(x1,y2,0.5,x2,1,z1)"),
                                                   2, [](CustomCompoundBondForce& force, auto& p) {
                                                       force.addBond(p);
                                                   });
     }},
    {"CustomCentroidBondForce", makeCentroidBonds},
    {"CustomCentroidBondForce, two chains",
     [](double) {
         return makeCentroidsOfTwoChains(true);
     }},
    {"CustomCentroidBondForce, not periodic",
     [](double) {
         return makeCentroidsOfTwoChains(false);
     }},
    {"CustomExternalForce",
     [](double) {
         return makePlaces("a*sin(x+y)+0.01*z^2");
     }},
    {"CustomExternalForce, periodicdistance",
     [](double) {
         return makePlaces("0.3*periodicdistance(x,y,z,a,0.4,b)^2");
     }},
    {"CustomExternalForce, of an image", // it changes if a particle is shifted by vectors of a skewed box
     [](double) {
         return makePlaces("0.5*periodicdistance(x,y,b,0.1,0.4,z*z/9)");
     }},
};

#endif /*OPENMM_CHAINTREE_PERIODICFORCES_H_*/
