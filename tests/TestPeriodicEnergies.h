/**
 * This tests native energies in periodic boxes: the plan, and the energy that sampling holds for each kind of Force in
 * each box, against sums over all images and OpenMM's energies, on one platform.
 */

#include "openmm/serialization/XmlSerializer.h"
#include "openmm/VerletIntegrator.h"
#include "PeriodicForces.h"
#include <iomanip>
#include <memory>

typedef TorsionMonteCarloIntegrator Sampler;

static void addMoves(Sampler& integrator, double width)
{
    integrator.addTorsionMove(1, 1.0);
    integrator.addRigidBodyMove(1, 0.8 * width, 2);
    integrator.setRandomNumberSeed(5);
    integrator.setTrialsPerStep(40);
}

static void assertNative(const Sampler& integrator, Context& context)
{
    for (const Sampler::PlannedEnergy& planned : integrator.getEnergyPlan(context))
        if (planned.force > 0 && planned.kind != Sampler::Native)
            throw OpenMMException(planned.name + ": " + planned.reason);
}

/**
 * A Context with copies of the Forces of a System on another platform, without the StericExclusionForce.
 */
class OtherContext {
public:
    OtherContext(const System& original, const string& platform, bool hasDirectSpace = true) :
        system(XmlSerializer::clone<System>(original)), integrator(0.001)
    {
        system->removeForce(0);
        if (!hasDirectSpace)
            dynamic_cast<NonbondedForce&>(system->getForce(0)).setIncludeDirectSpace(false);
        context = make_unique<Context>(*system, integrator, Platform::getPlatform(platform));
    }
    double computeEnergy(const State& state)
    {
        Box box;
        state.getPeriodicBoxVectors(box[0], box[1], box[2]);
        context->setPeriodicBoxVectors(box[0], box[1], box[2]);
        context->setPositions(state.getPositions());
        return context->getState(State::Energy).getPotentialEnergy();
    }
    /**
     * Compute the square root of the sum of all squared forces.
     */
    double computeGradient(const State& state)
    {
        computeEnergy(state);
        double sum = 0;
        const State computed = context->getState(State::Forces);
        for (const Vec3& force : computed.getForces())
            sum += force.dot(force);
        return sqrt(sum);
    }

private:
    unique_ptr<System> system;
    VerletIntegrator integrator;
    unique_ptr<Context> context;
};

/**
 * The largest errors of the energies of a kind of Force in a box, as parts of the sum of the magnitudes of all pairs,
 * or of U if it has no pairs: errors of the energy that sampling holds, and of OpenMM's platforms.
 */
struct Errors {
    double held = 0, ofReference = 0, ofCPU = 0;
};

/** Where the steepest pair dominates an energy, it changes by about itself over this distance, nm. */
const double OVERLAP_LENGTH = 0.1;

/**
 * Sampling with one Force. Its energy is expected to be the sum over all images if it is one of pairs, and else that of
 * OpenMM's Reference platform. Of Ewald summation the sum is direct space, and OpenMM knows reciprocal space.
 */
class SampledKind {
public:
    SampledKind(const PeriodicKind& kind, const Box& box, Platform& platform) :
        kind(kind), chains(box), made(kind.make(chains.width)), integrator(300)
    {
        chains.system.addForce(made);
        if (kind.makePartner) {
            chains.system.addForce(kind.makePartner(chains.width));
            integrator.setTrialsPerOuterTest(2); // in the small box few tests would pass otherwise
        }
        addMoves(integrator, chains.width);
        integrator.setTrialsPerStep(200);
        if (kind.computeWhole)
            longRange = integrateLongRange(kind, chains.width);
        context = make_unique<Context>(chains.system, integrator, platform);
        context->setPositions(chains.positions);
        reference = make_unique<OtherContext>(chains.system, "Reference");
        const NonbondedForce* nonbonded = dynamic_cast<const NonbondedForce*>(made);
        if (nonbonded != NULL && isEwald(*nonbonded))
            reciprocal = make_unique<OtherContext>(chains.system, "Reference", false);
        setBox(box);
        assertNative(integrator, *context);
    }
    /**
     * Change the box. OpenMM's CPU platform makes no new list of neighbors if only the box changes.
     */
    void setBox(const Box& changed)
    {
        box = changed;
        context->setPeriodicBoxVectors(box[0], box[1], box[2]);
        if (kind.hasPairs())
            cpu = make_unique<OtherContext>(chains.system, "CPU");
    }
    void sample(int numSteps)
    {
        compare();
        for (int i = 0; i < numSteps; i++) {
            integrator.step(1);
            compare();
        }
    }
    /**
     * Check that trials were accepted, that molecules have left the box, and that terms are longer than half of it.
     */
    void assertMoved() const
    {
        for (int move = 0; move < integrator.getNumMoves(); move++)
            if (Statistics(integrator, move).accepted <= (kind.makePartner ? 5 : reciprocal ? 20 : 50))
                throw OpenMMException(kind.name + ": move " + to_string(move) + " was accepted in " +
                                      to_string(Statistics(integrator, move).accepted) + " trials");
        const vector<Vec3> x = getPositions(*context);
        int numOutside = 0, numLong = 0;
        for (int i = 0; i < NUM_BEADS; i++) {
            const vector<int> ends = getTerm(i, 2);
            numOutside += getDistance(reduce(x[i], box), x[i]) > 1;
            numLong += getDistance(x[ends[0]], x[ends[1]]) > 0.5 * chains.width;
        }
        ASSERT(numOutside > 10 && numLong > 10);
    }
    /**
     * Terms are in double, pairs in single precision, as on OpenMM's CPU platform. Lists of neighbors of the Reference
     * platform lack pairs where boxes are not rectangular. OpenMM integrates long-range corrections in steps.
     */
    void assertSmallErrors() const
    {
        const double rounding = getTolerance(context->getPlatform()) > 1e-12 ? 1e-4 : kind.hasPairs() ? 4e-6 : 1e-11;
        ASSERT(errors.held < rounding);
        ASSERT(errors.ofCPU < 1e-5);
        if (isRectangular(box))
            ASSERT(errors.ofReference < (kind.computeWhole ? 1e-6 : 1e-12));
    }
    Errors errors;

private:
    void compare()
    {
        const State state = context->getState(State::Positions);
        const double held = integrator.getPotentialEnergy(*context), ofReference = reference->computeEnergy(state);
        double expected = ofReference, size = fabs(ofReference);
        if (kind.computePair) {
            expected = sumPairs(kind, state.getPositions(), box, chains.width, size);
            const NonbondedForce* nonbonded = dynamic_cast<const NonbondedForce*>(made);
            if (nonbonded != NULL)
                expected += sumBesidePairs(*nonbonded, chains.system, state.getPositions(), box, chains.width, size);
            if (reciprocal)
                expected += reciprocal->computeEnergy(state);
            expected += longRange / (box[0][0] * box[1][1] * box[2][2]);
        }
        if (kind.hasPairs()) /* single precision rounds distances; two beads may overlap after the box has changed */
            size = max(size, OVERLAP_LENGTH * reference->computeGradient(state));
        if (kind.computeValues)
            expected = kind.computeValues(state.getPositions(), box, chains.width, size);
        if (cpu)
            errors.ofCPU = max(errors.ofCPU, fabs(cpu->computeEnergy(state) - expected) / size);
        errors.ofReference = max(errors.ofReference, fabs(ofReference - expected) / size);
        errors.held = max(errors.held, fabs(held - expected) / size);
    }
    const PeriodicKind& kind;
    PeriodicChains chains;
    Force* made;
    Sampler integrator;
    unique_ptr<Context> context;
    unique_ptr<OtherContext> reference, cpu, reciprocal;
    Box box;
    double longRange = 0;
};

static void printTable(const string& title, const vector<PeriodicKind>& kinds, const vector<vector<Errors>>& errors,
                       double Errors::*column)
{
    cout << left << setw(44) << title;
    for (const NamedBox& box : BOXES)
        cout << setw(14) << box.name;
    cout << setprecision(1) << scientific << endl;
    for (size_t i = 0; i < kinds.size(); i++) {
        cout << setw(44) << kinds[i].name;
        for (const Errors& inBox : errors[i])
            cout << setw(14) << inBox.*column;
        cout << endl;
    }
}

/**
 * Sample with each kind of Force in each box, also after the box has changed.
 */
void testKindsInBoxes(Platform& platform)
{
    for (const vector<PeriodicKind>& kinds :
         {NONBONDED_KINDS, EWALD_KINDS, EXPRESSION_KINDS, VALUE_KINDS, TERM_KINDS}) {
        vector<vector<Errors>> errors;
        for (const PeriodicKind& kind : kinds) {
            errors.push_back({});
            for (const NamedBox& box : BOXES) {
                if (kind.needsRectangle && !isRectangular(box.vectors)) {
                    errors.back().push_back({});
                    continue;
                }
                SampledKind sampled(kind, box.vectors, platform);
                sampled.sample(10);
                sampled.assertMoved();
                sampled.setBox({{box.vectors[0] * 1.1, box.vectors[1] * 1.1, box.vectors[2] * 1.1}});
                sampled.sample(2);
                sampled.assertSmallErrors();
                errors.back().push_back(sampled.errors);
            }
        }
        printTable("Energies held", kinds, errors, &Errors::held);
        if (kinds[0].hasPairs()) {
            printTable("Reference platform", kinds, errors, &Errors::ofReference);
            printTable("CPU platform", kinds, errors, &Errors::ofCPU);
        }
    }
}

/**
 * Sample with all kinds of Forces at once.
 */
void testForcesTogether(Platform& platform)
{
    for (const Box& box : {BOXES[1].vectors, BOXES[7].vectors}) {
        PeriodicChains chains(box);
        chains.system.addForce(NONBONDED_KINDS.back().make(chains.width));
        for (const vector<PeriodicKind>& kinds : {EXPRESSION_KINDS, TERM_KINDS})
            for (const PeriodicKind& kind : kinds)
                chains.system.addForce(kind.make(chains.width));
        Sampler integrator(300);
        addMoves(integrator, chains.width);
        Context context(chains.system, integrator, platform);
        context.setPositions(chains.positions);
        assertNative(integrator, context);
        OtherContext reference(chains.system, "Reference");
        for (int i = 0; i < 10; i++) {
            integrator.step(1);
            const double expected = reference.computeEnergy(context.getState(State::Positions));
            ASSERT(fabs(expected - integrator.getPotentialEnergy(context)) <= 2e-6 * (100 + fabs(expected)));
        }
        for (int move = 0; move < integrator.getNumMoves(); move++)
            ASSERT(Statistics(integrator, move).accepted > 0);
    }
}

/**
 * A parameter scales an energy and its long-range correction.
 */
void testScaledCorrection(Platform& platform)
{
    PeriodicChains chains(BOXES[0].vectors);
    CustomNonbondedForce* force = makeCustomNonbonded("c*" + SLOW_DECAY, 1);
    force->addGlobalParameter("c", 1);
    force->setUseLongRangeCorrection(true);
    chains.system.addForce(force);
    Sampler integrator(300);
    addMoves(integrator, chains.width);
    Context context(chains.system, integrator, platform);
    context.setPositions(chains.positions);
    integrator.step(1);
    assertNative(integrator, context);
    const double energy = integrator.getPotentialEnergy(context);
    context.setParameter("c", 3);
    ASSERT_EQUAL_TOL(3 * energy, integrator.getPotentialEnergy(context), 1e-6);
    OtherContext reference(chains.system, "Reference");
    context.setParameter("c", 1);
    ASSERT_EQUAL_TOL(energy, integrator.getPotentialEnergy(context), 1e-12);
    ASSERT_EQUAL_TOL(energy, reference.computeEnergy(context.getState(State::Positions)), 1e-6);
}

/**
 * Molecules that are set elsewhere by sums of box vectors have the same energy.
 */
static void testLatticeVectors(Platform& platform, const PeriodicKind& nonbonded)
{
    const Box& box = BOXES[5].vectors;
    PeriodicChains chains(box);
    chains.system.addForce(nonbonded.make(chains.width));
    chains.system.addForce(EXPRESSION_KINDS[0].make(chains.width));
    for (int kind : {0, 2, 3})
        chains.system.addForce(TERM_KINDS[kind].make(chains.width));
    Sampler integrator(300);
    addMoves(integrator, chains.width);
    Context context(chains.system, integrator, platform);
    context.setPositions(chains.positions);
    mt19937 random(11);
    uniform_int_distribution<int> count(-10000, 10000);
    for (int i = 0; i < 5; i++) {
        integrator.step(2);
        const double expected = integrator.getPotentialEnergy(context);
        vector<Vec3> positions = getPositions(context);
        for (int chain = 0; chain < NUM_CHAINS; chain++) {
            const Vec3 shift = box[0] * count(random) + box[1] * count(random) + box[2] * count(random);
            for (int bead = chain * LENGTH; bead < (chain + 1) * LENGTH; bead++)
                positions[bead] += shift;
        }
        context.setPositions(positions);
        const double tolerance = 2e-6 + 100 * getRounding(platform);
        ASSERT(fabs(expected - integrator.getPotentialEnergy(context)) <= tolerance * (100 + fabs(expected)));
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
    PeriodicChains chains(BOXES[0].vectors);
    System& system = chains.system;
    system.addForce(NONBONDED_KINDS[0].make(chains.width));
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
    if (withoutImages != -1)
        assertForeign(integrator, context, withoutImages, "no periodic images");
    integrator.step(3);
    ASSERT_EQUAL_TOL(context.getState(State::Energy).getPotentialEnergy(), integrator.getPotentialEnergy(context),
                     1e-4);
}

/**
 * OpenMM evaluates reciprocal space alone, in outer tests. Its group may be another one, but not left out.
 */
void testPlanOfEwald(Platform& platform)
{
    for (int group : {-1, 3}) {
        PeriodicChains chains(BOXES[1].vectors);
        NonbondedForce* pairs = makeEwald(chains.width, NonbondedForce::PME, false);
        pairs->setReciprocalSpaceForceGroup(group);
        if (platform.getName() == "Reference")
            pairs->setPMEParameters(getAlpha(chains.width), 11, 13, 11); // sizes that other platforms do not use
        chains.system.addForce(pairs);
        Sampler integrator(300);
        addMoves(integrator, chains.width);
        Context context(chains.system, integrator, platform);
        context.setPositions(chains.positions);
        OtherContext reference(chains.system, "Reference");
        auto assertPlanned = [&](const string& time) {
            ASSERT_EQUAL("openmm-chaintree evaluates the pairs that a trial changes; OpenMM evaluates its reciprocal "
                         "space " +
                             time,
                         integrator.getEnergyPlan(context)[1].reason);
            const double expected = reference.computeEnergy(context.getState(State::Positions));
            ASSERT(fabs(expected - integrator.getPotentialEnergy(context)) <= 1e-5 * (100 + fabs(expected)));
        };
        assertPlanned("at each outer test, every 12 trials while its spread is measured");
        integrator.step(2);
        integrator.setTrialsPerOuterTest(20);
        assertPlanned("at each outer test, every 20 trials");
        integrator.setTemperature(0);
        integrator.setTrialsPerOuterTest(0);
        const double before = integrator.getPotentialEnergy(context);
        integrator.step(2);
        assertPlanned("in each trial");
        ASSERT(integrator.getPotentialEnergy(context) < before);
        integrator.setIntegrationForceGroups(1);
        if (group == 3)
            assertForeign(integrator, context, 1, "one of its two force groups is not an integration force group");
    }
    PeriodicChains chains(BOXES[1].vectors);
    chains.system.addForce(makeEwald(chains.width, NonbondedForce::LJPME, false));
    Sampler integrator(300);
    addMoves(integrator, chains.width);
    Context context(chains.system, integrator, platform);
    context.setPositions(chains.positions);
    assertForeign(integrator, context, 1, "no code for LJPME");
}

/**
 * A NonbondedForce without images is foreign if spheres have images, and native if they have none.
 */
void testPairsWithoutImages(Platform& platform)
{
    for (NonbondedForce::NonbondedMethod method : {NonbondedForce::NoCutoff, NonbondedForce::CutoffNonPeriodic})
        for (bool spheresArePeriodic : {false, true}) {
            PeriodicChains chains(BOXES[4].vectors, spheresArePeriodic);
            NonbondedForce* force = makeNonbonded(1.2);
            force->setNonbondedMethod(method);
            chains.system.addForce(force);
            Sampler integrator(300);
            addMoves(integrator, chains.width);
            integrator.setTrialsPerStep(10);
            Context context(chains.system, integrator, platform);
            context.setPositions(chains.positions);
            if (spheresArePeriodic)
                assertForeign(integrator, context, 1, "no periodic images");
            else
                assertNative(integrator, context);
            OtherContext reference(chains.system, "Reference");
            integrator.step(5);
            ASSERT_EQUAL_TOL(reference.computeEnergy(context.getState(State::Positions)),
                             integrator.getPotentialEnergy(context), 1e-5);
        }
}

/**
 * Without images of spheres, periodic Forces are foreign.
 */
void testSpheresWithoutImages(Platform& platform)
{
    PeriodicChains chains(BOXES[0].vectors, false);
    chains.system.addForce(TERM_KINDS[0].make(chains.width));
    chains.system.addForce(TERM_KINDS[1].make(chains.width));
    chains.system.addForce(NONBONDED_KINDS[0].make(chains.width));
    Sampler integrator(300);
    addMoves(integrator, chains.width);
    Context context(chains.system, integrator, platform);
    context.setPositions(chains.positions);
    assertForeign(integrator, context, 1, "it uses periodic boundary conditions");
    ASSERT_EQUAL(Sampler::Native, integrator.getEnergyPlan(context)[2].kind);
    assertForeign(integrator, context, 3, "its cutoff is periodic");
}

void testPeriodicEnergies(Platform& platform)
{
    testKindsInBoxes(platform);
    testForcesTogether(platform);
    testScaledCorrection(platform);
    testLatticeVectors(platform, NONBONDED_KINDS.back());
    testLatticeVectors(platform, EWALD_KINDS[1]);
    testForeignInBox(platform);
    testPlanOfEwald(platform);
    testPairsWithoutImages(platform);
    testSpheresWithoutImages(platform);
}
