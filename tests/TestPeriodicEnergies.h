/**
 * This tests native energies in periodic boxes against OpenMM's Reference platform: the plan, and the energy that
 * sampling holds, on one platform.
 */

#include "openmm/CustomBondForce.h"
#include "openmm/CustomCompoundBondForce.h"
#include "openmm/CustomExternalForce.h"
#include "openmm/CustomNonbondedForce.h"
#include "openmm/HarmonicAngleForce.h"
#include "openmm/HarmonicBondForce.h"
#include "openmm/internal/NonbondedForceImpl.h"
#include "openmm/NonbondedForce.h"
#include "openmm/PeriodicTorsionForce.h"
#include "openmm/RBTorsionForce.h"
#include "openmm/serialization/XmlSerializer.h"
#include "openmm/VerletIntegrator.h"
#include "SamplingSupport.h"
#include <array>
#include <memory>
#include <random>

typedef TorsionMonteCarloIntegrator Sampler;
typedef array<Vec3, 3> Box;

/** Cubic, flat, a slab, a truncated octahedron, a rhombic dodecahedron, skewed, at the edge of the reduced form, and so
 *  small that a chain meets itself. */
static const vector<Box> BOXES = {
    {{Vec3(5, 0, 0), Vec3(0, 5, 0), Vec3(0, 0, 5)}},
    {{Vec3(6, 0, 0), Vec3(0, 5, 0), Vec3(0, 0, 3)}},
    {{Vec3(3, 0, 0), Vec3(0, 3, 0), Vec3(0, 0, 20)}},
    {{Vec3(5, 0, 0), Vec3(5 / 3.0, 4.714045207910317, 0), Vec3(-5 / 3.0, 2.3570226039551585, 4.08248290463863)}},
    {{Vec3(5, 0, 0), Vec3(0, 5, 0), Vec3(2.5, 2.5, 3.5355339059327378)}},
    {{Vec3(4, 0, 0), Vec3(1.3, 4.4, 0), Vec3(-1.1, 0.9, 5)}},
    {{Vec3(4, 0, 0), Vec3(2, 4, 0), Vec3(-2, 2, 4)}},
    {{Vec3(1.65, 0, 0), Vec3(0, 1.65, 0), Vec3(0, 0, 1.65)}},
};

static const int LENGTH = 6, NUM_CHAINS = 7, NUM_BEADS = LENGTH * NUM_CHAINS;

/**
 * Chains in a periodic box, and a Force of each kind.
 */
class PeriodicChains : public BeadChain {
public:
    explicit PeriodicChains(const Box& box, bool exceptionsArePeriodic = false, bool spheresArePeriodic = true) :
        BeadChain(LENGTH, 0.05, 1.0), box(box), width(min(box[0][0], min(box[1][1], box[2][2])))
    {
        system.setDefaultPeriodicBoxVectors(box[0], box[1], box[2]);
        force->setUsesPeriodicBoundaryConditions(spheresArePeriodic);
        mt19937 random(3);
        uniform_real_distribution<double> uniform(-3, 3);
        for (int chain = 1; chain < NUM_CHAINS; chain++)
            addMolecule(LENGTH, 0.05, 1.0 + chain, Vec3(uniform(random), uniform(random), uniform(random)));
        addBonded();
        addNonbonded(exceptionsArePeriodic);
        addCustomNonbonded();
    }
    /**
     * Compute the energy on the Reference platform, without the StericExclusionForce. In boxes that are not rectangular
     * its lists of neighbors lack pairs, so pairs are then summed here. Both are the same in rectangular boxes.
     */
    double computeEnergy(const State& state) const
    {
        unique_ptr<System> copy(XmlSerializer::clone<System>(system));
        copy->removeForce(0);
        for (int i = 0; i < copy->getNumForces(); i++)
            copy->getForce(i).setForceGroup(isPairForce(copy->getForce(i)) ? 1 : 0);
        VerletIntegrator integrator(0.001);
        Context context(*copy, integrator, Platform::getPlatform("Reference"));
        Box vectors;
        state.getPeriodicBoxVectors(vectors[0], vectors[1], vectors[2]);
        context.setPeriodicBoxVectors(vectors[0], vectors[1], vectors[2]);
        context.setPositions(state.getPositions());
        const double ofPairs = sumPairs(state.getPositions(), vectors);
        const double onReference = context.getState(State::Energy, false, 2).getPotentialEnergy();
        if (box[1][0] == 0 && box[2][0] == 0 && box[2][1] == 0)
            ASSERT(fabs(ofPairs - onReference) <= 1e-7 * (100 + fabs(ofPairs)));
        return context.getState(State::Energy, false, 1).getPotentialEnergy() + ofPairs;
    }
    const Box box;
    const double width;

private:
    static bool isPairForce(const Force& force)
    {
        return dynamic_cast<const NonbondedForce*>(&force) != NULL ||
               dynamic_cast<const CustomNonbondedForce*>(&force) != NULL;
    }
    static double computeLennardJones(double r, double sigma, double epsilon)
    {
        const double sixth = pow(sigma / r, 6);
        return 4 * epsilon * (sixth * sixth - sixth);
    }
    /**
     * Sum pairs of nearest images: of Lennard-Jones and charges, with their correction, and of the expression.
     */
    double sumPairs(const vector<Vec3>& x, const Box& vectors) const
    {
        const double coulomb = 138.93545764438198, cutoff = 0.499 * width, from = 0.35 * width, dielectric = 78.3;
        const double k = (dielectric - 1) / (2 * dielectric + 1) / pow(cutoff, 3);
        const double c = 3 * dielectric / (2 * dielectric + 1) / cutoff;
        const NonbondedForce& pairs = dynamic_cast<const NonbondedForce&>(system.getForce(8));
        double energy = NonbondedForceImpl::calcDispersionCorrection(system, pairs) /
                        (vectors[0][0] * vectors[1][1] * vectors[2][2]);
        set<pair<int, int>> excluded;
        auto reduce = [&](Vec3 apart) {
            for (int i = 2; i >= 0; i--)
                apart -= vectors[i] * floor(apart[i] / vectors[i][i] + 0.5);
            return apart;
        };
        for (int i = 0; i < pairs.getNumExceptions(); i++) {
            int p1, p2;
            double charges, sigma, epsilon;
            pairs.getExceptionParameters(i, p1, p2, charges, sigma, epsilon);
            excluded.insert(make_pair(p1, p2));
            Vec3 apart = x[p1] - x[p2];
            if (pairs.getExceptionsUsePeriodicBoundaryConditions())
                apart = reduce(apart);
            const double r = sqrt(apart.dot(apart));
            energy += computeLennardJones(r, sigma, epsilon) + coulomb * charges / r;
        }
        for (int i = 0; i < NUM_BEADS; i++)
            for (int j = 0; j < i; j++) {
                const Vec3 apart = reduce(x[i] - x[j]);
                const double r = sqrt(apart.dot(apart));
                if (r >= cutoff || excluded.count(make_pair(j, i)) != 0)
                    continue;
                double charge1, charge2, sigma1, sigma2, epsilon;
                pairs.getParticleParameters(i, charge1, sigma1, epsilon);
                pairs.getParticleParameters(j, charge2, sigma2, epsilon);
                const double t = max(0.0, (r - from) / (cutoff - from));
                energy += computeLennardJones(r, (sigma1 + sigma2) / 2, epsilon) *
                              (1 + t * t * t * (-10 + t * (15 - 6 * t))) +
                          coulomb * charge1 * charge2 * (1 / r + k * r * r - c);
                if (r < 0.4 * width && (i % 3 != 0 || j % 3 != 0))
                    energy += 1.5 * (0.2 + 0.1 * (i % 4)) * (0.2 + 0.1 * (j % 4)) * exp(-2 * r);
            }
        return energy;
    }
    void addBonded()
    {
        HarmonicBondForce* bonds[2] = {new HarmonicBondForce(), new HarmonicBondForce()};
        HarmonicAngleForce* angles = new HarmonicAngleForce();
        PeriodicTorsionForce* torsions = new PeriodicTorsionForce();
        RBTorsionForce* ryckaertBellemans = new RBTorsionForce();
        CustomBondForce* ends = new CustomBondForce("0.1*(r-1)^2");
        CustomCompoundBondForce* compound = new CustomCompoundBondForce(3, "distance(p1,p3)*angle(p1,p2,p3)");
        for (int i = 0; i < NUM_BEADS; i++) {
            const int place = i % LENGTH;
            for (HarmonicBondForce* force : bonds)
                if (place > 2)
                    force->addBond(i, i - 3, 0.9, 5);
            if (place > 2) {
                angles->addAngle(i, i - 1, i - 3, 1.5, 3);
                torsions->addTorsion(i - 3, i - 2, i - 1, i, 2, 0.3, 4);
                ryckaertBellemans->addTorsion(i - 3, i - 2, i - 1, i, 1, 0.5, -1, 0.3, 0, 0.1);
            }
            ends->addBond(i, (i + LENGTH + 1) % NUM_BEADS);
            if (place > 3)
                compound->addBond({i, i - 1, (i + 2 * LENGTH) % NUM_BEADS});
        }
        bonds[1]->setUsesPeriodicBoundaryConditions(true);
        for (HarmonicBondForce* force : bonds)
            system.addForce(force);
        angles->setUsesPeriodicBoundaryConditions(true);
        torsions->setUsesPeriodicBoundaryConditions(true);
        ryckaertBellemans->setUsesPeriodicBoundaryConditions(true);
        ends->setUsesPeriodicBoundaryConditions(true);
        compound->setUsesPeriodicBoundaryConditions(true);
        system.addForce(angles);
        system.addForce(torsions);
        system.addForce(ryckaertBellemans);
        system.addForce(ends);
        system.addForce(compound);
    }
    void addNonbonded(bool exceptionsArePeriodic)
    {
        NonbondedForce* pairs = new NonbondedForce();
        for (int i = 0; i < NUM_BEADS; i++) {
            pairs->addParticle(i % 2 == 0 ? 0.3 : -0.2, 0.1 + 0.01 * (i % 3), 0.5);
            for (int j = max(i - i % LENGTH, i - 2); j < i; j++)
                pairs->addException(j, i, i % 2 == 0 ? 0 : 0.05, 0.1, i % 2 == 0 ? 0 : 0.2);
        }
        pairs->setNonbondedMethod(NonbondedForce::CutoffPeriodic);
        pairs->setCutoffDistance(0.499 * width);
        pairs->setUseSwitchingFunction(true);
        pairs->setSwitchingDistance(0.35 * width);
        pairs->setExceptionsUsePeriodicBoundaryConditions(exceptionsArePeriodic);
        system.addForce(pairs);
    }
    void addCustomNonbonded()
    {
        CustomNonbondedForce* pairs = new CustomNonbondedForce("c*a1*a2*exp(-2*r)");
        pairs->addGlobalParameter("c", 1.5);
        pairs->addPerParticleParameter("a");
        set<int> some, all;
        for (int i = 0; i < NUM_BEADS; i++) {
            pairs->addParticle({0.2 + 0.1 * (i % 4)});
            all.insert(i);
            if (i % 3 != 0)
                some.insert(i);
            for (int j = max(i - i % LENGTH, i - 2); j < i; j++)
                pairs->addExclusion(j, i);
        }
        pairs->addInteractionGroup(some, all);
        pairs->setNonbondedMethod(CustomNonbondedForce::CutoffPeriodic);
        pairs->setCutoffDistance(0.4 * width);
        system.addForce(pairs);
    }
};

static void addMoves(Sampler& integrator, double width)
{
    integrator.addTorsionMove(1, 1.0);
    integrator.addRigidBodyMove(1, 0.8 * width, 2);
    integrator.setRandomNumberSeed(5);
    integrator.setTrialsPerStep(40);
}

static void assertHeldEnergy(const PeriodicChains& chains, const Sampler& integrator, Context& context)
{
    const double expected = chains.computeEnergy(context.getState(State::Positions));
    const double tolerance = getTolerance(context.getPlatform()) > 0 ? 1e-4 : 2e-6;
    ASSERT(fabs(expected - integrator.getPotentialEnergy(context)) <= tolerance * (100 + fabs(expected)));
}

/**
 * Sample with all Forces, and with a box that changes.
 */
void testEnergiesInBoxes(Platform& platform)
{
    for (const Box& box : BOXES)
        for (bool exceptionsArePeriodic : {false, true}) {
            PeriodicChains chains(box, exceptionsArePeriodic);
            Sampler integrator(300);
            addMoves(integrator, chains.width);
            Context context(chains.system, integrator, platform);
            context.setPositions(chains.positions);
            for (const Sampler::PlannedEnergy& planned : integrator.getEnergyPlan(context))
                if (planned.force > 0 && planned.kind != Sampler::Native)
                    throw OpenMMException(planned.name + ": " + planned.reason);
            for (int i = 0; i < 10; i++) {
                assertHeldEnergy(chains, integrator, context);
                integrator.step(1);
            }
            assertHeldEnergy(chains, integrator, context);
            for (int move = 0; move < integrator.getNumMoves(); move++)
                ASSERT(Statistics(integrator, move).accepted > 0);
            context.setPeriodicBoxVectors(box[0] * 1.1, box[1] * 1.1, box[2] * 1.1);
            for (int i = 0; i < 3; i++) {
                assertHeldEnergy(chains, integrator, context);
                integrator.step(1);
            }
        }
}

static void assertForeign(const Sampler& integrator, Context& context, int force, const string& reason)
{
    const Sampler::PlannedEnergy planned = integrator.getEnergyPlan(context)[force];
    ASSERT_EQUAL(Sampler::Foreign, planned.kind);
    if (planned.reason.find(reason) == string::npos)
        throw OpenMMException("expected \"" + reason + "\", found \"" + planned.reason + "\"");
}

/**
 * What has no native energy in a periodic box is left to OpenMM, which samples the same energy.
 */
void testForeignInBox(Platform& platform)
{
    PeriodicChains chains(BOXES[0]);
    System& system = chains.system;
    CustomExternalForce* places = new CustomExternalForce("x^2");
    places->addParticle(3);
    const int external = system.addForce(places);
    HarmonicBondForce* between = new HarmonicBondForce();
    between->addBond(0, LENGTH, 1, 2);
    const int acrossMolecules = system.addForce(between);
    CustomNonbondedForce* corrected = new CustomNonbondedForce("0.01/r^6");
    for (int i = 0; i < NUM_BEADS; i++) {
        corrected->addParticle();
        for (int j = max(i - i % LENGTH, i - 2); j < i; j++)
            corrected->addExclusion(j, i);
    }
    corrected->setNonbondedMethod(CustomNonbondedForce::CutoffPeriodic);
    corrected->setUseLongRangeCorrection(true);
    corrected->setCutoffDistance(1);
    const int withCorrection = system.addForce(corrected);
    int withoutImages = -1;
    if (platform.getName() == "Reference") { // others take no pairs with and without a cutoff
        CustomNonbondedForce* direct = new CustomNonbondedForce("0.01*r");
        for (int i = 0; i < NUM_BEADS; i++)
            direct->addParticle();
        withoutImages = system.addForce(direct);
    }
    Sampler integrator(300);
    addMoves(integrator, chains.width);
    Context context(system, integrator, platform);
    context.setPositions(chains.positions);
    assertForeign(integrator, context, external, "terms of places");
    assertForeign(integrator, context, acrossMolecules, "of several molecules");
    if (withoutImages != -1)
        assertForeign(integrator, context, withoutImages, "no periodic images");
    assertForeign(integrator, context, withCorrection, "long-range correction");
    integrator.step(3);
    ASSERT_EQUAL_TOL(context.getState(State::Energy).getPotentialEnergy(), integrator.getPotentialEnergy(context),
                     1e-4);
}

/**
 * Without images of spheres, periodic Forces are foreign.
 */
void testSpheresWithoutImages(Platform& platform)
{
    PeriodicChains chains(BOXES[0], false, false);
    Sampler integrator(300);
    addMoves(integrator, chains.width);
    Context context(chains.system, integrator, platform);
    context.setPositions(chains.positions);
    assertForeign(integrator, context, 2, "it uses periodic boundary conditions");
    assertForeign(integrator, context, 8, "its cutoff is periodic");
    ASSERT_EQUAL(Sampler::Native, integrator.getEnergyPlan(context)[1].kind);
}

void testPeriodicEnergies(Platform& platform)
{
    testEnergiesInBoxes(platform);
    testForeignInBox(platform);
    testSpheresWithoutImages(platform);
}
