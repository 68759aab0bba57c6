#include "openmmchaintree/TorsionMonteCarloIntegrator.h"
#include "openmm/AndersenThermostat.h"
#include "openmm/CMMotionRemover.h"
#include "openmm/CompoundIntegrator.h"
#include "openmm/CustomIntegrator.h"
#include "openmm/internal/AssertionUtilities.h"
#include "openmm/internal/ContextImpl.h"
#include "openmm/internal/OSRngSeed.h"
#include "openmm/kernels.h"
#include "openmm/MonteCarloAnisotropicBarostat.h"
#include "openmm/MonteCarloBarostat.h"
#include "openmm/MonteCarloFlexibleBarostat.h"
#include "openmm/MonteCarloMembraneBarostat.h"
#include "openmm/NonbondedForce.h"
#include "openmm/OpenMMException.h"
#include "openmm/reference/SimTKOpenMMRealType.h"
#include "openmm/serialization/SerializationNode.h"
#include "openmm/VerletIntegrator.h"
#include "openmmchaintree/internal/ArgumentChecks.h"
#include "openmmchaintree/internal/CheckpointStream.h"
#include "openmmchaintree/internal/MonteCarloMove.h"
#include "openmmchaintree/internal/RandomNumberGenerator.h"
#include "openmmchaintree/internal/StericExclusionForceImpl.h"
#include <cmath>
#include <limits>
#include <sstream>

using namespace ChainTreePlugin;
using namespace OpenMM;
using namespace std;

/** What the integrator's part of a checkpoint begins with: "ChainTMC" where the first byte is the lowest. */
static const uint64_t CHECKPOINT_MARK = 0x434d546e69616843;

static const int NEWEST_CHECKPOINT_VERSION = 1;

static const int NEWEST_STATE_VERSION = 1;

static void fail(const string& message)
{
    throw OpenMMException("TorsionMonteCarloIntegrator: " + message);
}

/**
 * Name a move when something is wrong with it.
 */
static string describeMove(size_t index)
{
    return "TorsionMonteCarloIntegrator: move " + to_string(index);
}

/**
 * Get the one StericExclusionForce in a Context.
 */
static StericExclusionForceImpl& findForce(ContextImpl& context)
{
    StericExclusionForceImpl* found = NULL;
    for (ForceImpl* impl : context.getForceImpls()) {
        StericExclusionForceImpl* candidate = dynamic_cast<StericExclusionForceImpl*>(impl);
        if (candidate != NULL && found != NULL)
            fail("the System has more than one StericExclusionForce");
        if (candidate != NULL)
            found = candidate;
    }
    if (found == NULL)
        fail("the System has no StericExclusionForce");
    return *found;
}

/**
 * Throw an exception if a Force changes the periodic box, which rigid molecules and their distances know nothing of.
 */
static void checkNoBarostat(const System& system)
{
    for (int i = 0; i < system.getNumForces(); i++) {
        const Force* force = &system.getForce(i);
        if (dynamic_cast<const MonteCarloBarostat*>(force) != NULL ||
            dynamic_cast<const MonteCarloAnisotropicBarostat*>(force) != NULL ||
            dynamic_cast<const MonteCarloMembraneBarostat*>(force) != NULL ||
            dynamic_cast<const MonteCarloFlexibleBarostat*>(force) != NULL)
            fail("the System has a barostat (force " + to_string(i) + ", " + force->getName() +
                 "), but periodic boundary conditions are not supported; remove it");
    }
}

/**
 * Throw an exception if a move could break a constraint.
 */
static void checkConstraints(const System& system, const LinkStructure& structure)
{
    for (int i = 0; i < system.getNumConstraints(); i++) {
        int particle1, particle2;
        double distance;
        system.getConstraintParameters(i, particle1, particle2, distance);
        string name = "the constraint between particles " + to_string(particle1) + " and " + to_string(particle2) +
                      " cannot hold: ";
        if (structure.getParticleMolecule(particle1) != structure.getParticleMolecule(particle2))
            fail(name + "they are in different molecules of the StericExclusionForce; add a bond between them");
        int torsion = structure.findTorsionBetween(particle1, particle2);
        if (torsion != -1)
            fail(name + "torsion " + to_string(torsion) + " moves them relative to each other");
    }
}

/**
 * Get the groups of all Forces that can contribute to U, as a bit mask. OpenMM too goes by the groups that Forces had
 * when the Context was created.
 */
static int findGroupsWithEnergy(const System& system)
{
    unsigned int groups = 0;
    for (int i = 0; i < system.getNumForces(); i++) {
        const Force* force = &system.getForce(i);
        if (dynamic_cast<const CMMotionRemover*>(force) != NULL ||
            dynamic_cast<const AndersenThermostat*>(force) != NULL ||
            dynamic_cast<const StericExclusionForce*>(force) != NULL)
            continue;
        groups |= 1u << force->getForceGroup();
        const NonbondedForce* nonbonded = dynamic_cast<const NonbondedForce*>(force);
        if (nonbonded != NULL && nonbonded->getReciprocalSpaceForceGroup() >= 0)
            groups |= 1u << nonbonded->getReciprocalSpaceForceGroup();
    }
    return groups;
}

/**
 * Get whether an Integrator, or one of those in a CompoundIntegrator, begins its steps without a word to the Forces.
 */
static bool hasSilentSteps(const Integrator& integrator)
{
    if (auto compound = dynamic_cast<const CompoundIntegrator*>(&integrator)) {
        for (int i = 0; i < compound->getNumIntegrators(); i++)
            if (hasSilentSteps(compound->getIntegrator(i)))
                return true;
        return false;
    }
    auto custom = dynamic_cast<const CustomIntegrator*>(&integrator);
    if (custom == NULL)
        return false;
    for (int i = 0; i < custom->getNumComputations(); i++) {
        CustomIntegrator::ComputationType type;
        string variable, expression;
        custom->getComputationStep(i, type, variable, expression);
        if (type == CustomIntegrator::UpdateContextState)
            return false;
    }
    return true;
}

/**
 * Get whether an energy is one that a state can have: neither NaN nor minus infinity, whose probability no other state
 * would have a part of.
 */
static bool isEnergy(double energy)
{
    return energy > -numeric_limits<double>::infinity();
}

/**
 * A move, how often it is drawn, and what became of its trials.
 */
class TorsionMonteCarloIntegrator::MoveInfo {
public:
    MoveInfo(unique_ptr<MonteCarloMove> move, double weight) :
        move(std::move(move)), weight(weight), clashed(0), rejectedByEnergy(0), accepted(0)
    {
    }
    unique_ptr<MonteCarloMove> move;
    double weight;
    long long clashed, rejectedByEnergy, accepted;
};

TorsionMonteCarloIntegrator::TorsionMonteCarloIntegrator(double temperature) :
    trialsPerStep(100), initialClashPolicy(Tolerate), stericMode(Hard), force(NULL), groupsWithEnergy(0)
{
    setTemperature(temperature);
    setRandomNumberSeed(0);
    setStepSize(0);
    setConstraintTolerance(1e-5);
}

TorsionMonteCarloIntegrator::~TorsionMonteCarloIntegrator()
{
}

double TorsionMonteCarloIntegrator::getTemperature() const
{
    return temperature;
}

void TorsionMonteCarloIntegrator::setTemperature(double temperature)
{
    checkNotNegative(temperature, "TorsionMonteCarloIntegrator: the temperature");
    this->temperature = temperature;
}

int TorsionMonteCarloIntegrator::getRandomNumberSeed() const
{
    return randomNumberSeed;
}

void TorsionMonteCarloIntegrator::setRandomNumberSeed(int seed)
{
    randomNumberSeed = seed;
}

int TorsionMonteCarloIntegrator::getTrialsPerStep() const
{
    return trialsPerStep;
}

void TorsionMonteCarloIntegrator::setTrialsPerStep(int trials)
{
    if (trials < 1)
        fail("the number of trials per step must be at least 1, but is " + to_string(trials));
    trialsPerStep = trials;
}

TorsionMonteCarloIntegrator::InitialClashPolicy TorsionMonteCarloIntegrator::getInitialClashPolicy() const
{
    return initialClashPolicy;
}

void TorsionMonteCarloIntegrator::setInitialClashPolicy(InitialClashPolicy policy)
{
    if (policy != Tolerate && policy != Refuse)
        fail("the initial clash policy must be Tolerate or Refuse, but is " + to_string((int)policy));
    initialClashPolicy = policy;
}

TorsionMonteCarloIntegrator::StericMode TorsionMonteCarloIntegrator::getStericMode() const
{
    return stericMode;
}

void TorsionMonteCarloIntegrator::setStericMode(StericMode mode)
{
    if (mode != Hard && mode != Soft)
        fail("the steric mode must be Hard or Soft, but is " + to_string((int)mode));
    stericMode = mode;
}

int TorsionMonteCarloIntegrator::getNumToleratedClashes(Context& context) const
{
    requireContext(context);
    return force->getNumToleratedClashes(*this->context);
}

int TorsionMonteCarloIntegrator::addTorsionMove(double weight, double maxAngle, const vector<int>& torsions, int count)
{
    checkNotNegative(maxAngle, "TorsionMonteCarloIntegrator: the largest angle of a torsion move");
    if (count < 1)
        fail("the number of torsions that a move turns must be at least 1, but is " + to_string(count));
    return addMove(make_unique<ChainTreePlugin::TorsionMove>(maxAngle, torsions, count), weight);
}

int TorsionMonteCarloIntegrator::addRigidBodyMove(double weight, double maxTranslation, double maxAngle,
                                                  const vector<int>& molecules)
{
    checkNotNegative(maxTranslation, "TorsionMonteCarloIntegrator: the largest translation of a rigid body move");
    checkNotNegative(maxAngle, "TorsionMonteCarloIntegrator: the largest angle of a rigid body move");
    return addMove(make_unique<ChainTreePlugin::RigidBodyMove>(maxTranslation, maxAngle, molecules), weight);
}

int TorsionMonteCarloIntegrator::addMove(unique_ptr<MonteCarloMove> move, double weight)
{
    checkNotNegative(weight, "TorsionMonteCarloIntegrator: the weight of a move");
    if (force != NULL)
        move->bind(force->getLinkStructure(), describeMove(moves.size()));
    moves.push_back(MoveInfo(std::move(move), weight));
    return moves.size() - 1;
}

int TorsionMonteCarloIntegrator::getNumMoves() const
{
    return moves.size();
}

TorsionMonteCarloIntegrator::MoveType TorsionMonteCarloIntegrator::getMoveType(int move) const
{
    ASSERT_VALID_INDEX(move, moves);
    return moves[move].move->getType();
}

/**
 * Get a move as the class that it must be, and its weight.
 */
template <class Move>
const Move& TorsionMonteCarloIntegrator::getMove(int index, double& weight, const string& kind) const
{
    ASSERT_VALID_INDEX(index, moves);
    const Move* move = dynamic_cast<const Move*>(moves[index].move.get());
    if (move == NULL)
        fail("move " + to_string(index) + " is not a " + kind + " move");
    weight = moves[index].weight;
    return *move;
}

void TorsionMonteCarloIntegrator::getTorsionMoveParameters(int move, double& weight, double& maxAngle,
                                                           vector<int>& torsions, int& count) const
{
    auto& found = getMove<ChainTreePlugin::TorsionMove>(move, weight, "torsion");
    maxAngle = found.getMaxAngle();
    torsions = found.getTorsions();
    count = found.getCount();
}

void TorsionMonteCarloIntegrator::getRigidBodyMoveParameters(int move, double& weight, double& maxTranslation,
                                                             double& maxAngle, vector<int>& molecules) const
{
    auto& found = getMove<ChainTreePlugin::RigidBodyMove>(move, weight, "rigid body");
    maxTranslation = found.getMaxTranslation();
    maxAngle = found.getMaxAngle();
    molecules = found.getMolecules();
}

void TorsionMonteCarloIntegrator::getMoveStatistics(int move, long long& attempted, long long& clashed,
                                                    long long& rejectedByEnergy, long long& accepted) const
{
    ASSERT_VALID_INDEX(move, moves);
    const MoveInfo& info = moves[move];
    attempted = info.clashed + info.rejectedByEnergy + info.accepted;
    clashed = info.clashed;
    rejectedByEnergy = info.rejectedByEnergy;
    accepted = info.accepted;
}

void TorsionMonteCarloIntegrator::resetMoveStatistics()
{
    for (MoveInfo& info : moves)
        info.clashed = info.rejectedByEnergy = info.accepted = 0;
}

void TorsionMonteCarloIntegrator::requireContext(const Context& context) const
{
    if (this->context == NULL || &this->context->getOwner() != &context)
        fail("it is not bound to this Context");
}

void TorsionMonteCarloIntegrator::getTorsionAngles(Context& context, vector<double>& angles) const
{
    requireContext(context);
    force->getTorsionAngles(*this->context, angles);
}

void TorsionMonteCarloIntegrator::setTorsionAngles(Context& context, const vector<double>& angles) const
{
    requireContext(context);
    force->setTorsionAngles(*this->context, angles);
}

void TorsionMonteCarloIntegrator::initialize(ContextImpl& contextRef)
{
    if (owner != NULL && &contextRef.getOwner() != owner)
        throw OpenMMException("This Integrator is already bound to a context");
    const System& system = contextRef.getSystem();
    StericExclusionForceImpl& found = findForce(contextRef);
    checkNoBarostat(system);
    checkConstraints(system, found.getLinkStructure());
    for (size_t i = 0; i < moves.size(); i++)
        moves[i].move->bind(found.getLinkStructure(), describeMove(i));

    // This kernel is never executed, but on GPUs only an integrator's kernel initializes what a Context needs.

    kernel = contextRef.getPlatform().createKernel(IntegrateVerletStepKernel::Name(), contextRef);
    kernel.getAs<IntegrateVerletStepKernel>().initialize(system, VerletIntegrator(getStepSize()));
    random.reset(new RandomNumberGenerator(randomNumberSeed == 0 ? osrngseed() : randomNumberSeed));
    found.expectDynamics(!hasSilentSteps(contextRef.getIntegrator()));
    groupsWithEnergy = findGroupsWithEnergy(system);
    force = &found;
    context = &contextRef;
    owner = &contextRef.getOwner();
}

void TorsionMonteCarloIntegrator::cleanup()
{
    force = NULL;
    random.reset();
    kernel = Kernel();
    restoredPositions.clear();
}

vector<string> TorsionMonteCarloIntegrator::getKernelNames()
{
    return {IntegrateVerletStepKernel::Name()};
}

void TorsionMonteCarloIntegrator::stateChanged(State::DataType changed)
{
    if (force == NULL || changed != State::Positions)
        return;
    vector<Vec3> restored;
    restored.swap(restoredPositions);
    force->positionsWereSet(*context, restored);
}

void TorsionMonteCarloIntegrator::createCheckpoint(ostream& stream) const
{
    CheckpointWriter writer(stream);
    writer.write(CHECKPOINT_MARK);
    writer.write(NEWEST_CHECKPOINT_VERSION);
    vector<long long> statistics;
    for (const MoveInfo& info : moves)
        statistics.insert(statistics.end(), {info.clashed, info.rejectedByEnergy, info.accepted});
    writer.write(statistics);
    string randomState = random->getState();
    writer.write(vector<char>(randomState.begin(), randomState.end()));
    force->createCheckpoint(writer);
}

void TorsionMonteCarloIntegrator::loadCheckpoint(istream& stream)
{
    CheckpointReader reader(stream);
    try {
        restoreCheckpoint(reader);
    }
    catch (...) {
        // The Context has the checkpoint's positions already.

        force->restartLimits();
        throw;
    }
}

void TorsionMonteCarloIntegrator::restoreCheckpoint(CheckpointReader& reader)
{
    if (reader.read<uint64_t>() != CHECKPOINT_MARK)
        fail("the checkpoint was created with another Integrator");
    checkVersion(reader.read<int>(), NEWEST_CHECKPOINT_VERSION, "the checkpoint of a TorsionMonteCarloIntegrator");
    vector<long long> statistics = reader.readVector<long long>();
    if (statistics.size() != 3 * moves.size())
        fail("the checkpoint is of an integrator with " + to_string(statistics.size() / 3) +
             " moves, but this one has " + to_string(moves.size()));
    vector<char> randomState = reader.readVector<char>();
    RandomNumberGenerator restored(0);
    if (!restored.setState(string(randomState.begin(), randomState.end())))
        fail("the checkpoint is damaged");
    force->loadCheckpoint(reader);
    context->getPositions(restoredPositions);
    *random = restored;
    for (size_t i = 0; i < moves.size(); i++) {
        moves[i].clashed = statistics[3 * i];
        moves[i].rejectedByEnergy = statistics[3 * i + 1];
        moves[i].accepted = statistics[3 * i + 2];
    }
}

void TorsionMonteCarloIntegrator::serializeParameters(SerializationNode& node) const
{
    vector<pair<int, int>> pairs;
    vector<double> limits;
    force->getLimits(pairs, limits);
    node.setIntProperty("version", NEWEST_STATE_VERSION);
    SerializationNode& list = node.createChildNode("Limits");
    for (size_t i = 0; i < pairs.size(); i++)
        list.createChildNode("Limit")
            .setIntProperty("p1", pairs[i].first)
            .setIntProperty("p2", pairs[i].second)
            .setDoubleProperty("overlap", limits[i]);
}

void TorsionMonteCarloIntegrator::deserializeParameters(const SerializationNode& node)
{
    // Many integrators keep nothing in a State. Sampling may well start from what they have made.

    if (!node.hasProperty("version"))
        return;
    auto& children = node.getChildren();
    if (children.size() != 1 || children[0].getName() != "Limits")
        fail("the integrator parameters of the State are those of another Integrator");
    checkVersion(node.getIntProperty("version"), NEWEST_STATE_VERSION, "the State of a TorsionMonteCarloIntegrator");
    vector<pair<int, int>> pairs;
    vector<double> limits;
    for (auto& limit : children[0].getChildren()) {
        pairs.push_back(make_pair(limit.getIntProperty("p1"), limit.getIntProperty("p2")));
        limits.push_back(limit.getDoubleProperty("overlap"));
    }
    force->setLimits(*context, pairs, limits);
}

double TorsionMonteCarloIntegrator::computeKineticEnergy()
{
    const System& system = context->getSystem();
    vector<Vec3> velocities;
    context->getVelocities(velocities);
    double energy = 0;
    for (int i = 0; i < system.getNumParticles(); i++)
        energy += 0.5 * system.getParticleMass(i) * velocities[i].dot(velocities[i]);
    return energy;
}

double TorsionMonteCarloIntegrator::sumWeights() const
{
    if (moves.empty())
        fail("there are no moves; add one by addTorsionMove() or addRigidBodyMove()");
    double sum = 0;
    for (const MoveInfo& info : moves)
        sum += info.weight;
    if (sum == 0)
        fail("all moves have weight 0");
    return sum;
}

TorsionMonteCarloIntegrator::MoveInfo& TorsionMonteCarloIntegrator::drawMove(double weightSum)
{
    double position = random->drawUniform() * weightSum;
    size_t lastPossible = 0;
    for (size_t i = 0; i < moves.size(); i++) {
        if (moves[i].weight == 0)
            continue;
        lastPossible = i;
        if (position < moves[i].weight)
            break;
        position -= moves[i].weight;
    }
    return moves[lastPossible];
}

bool TorsionMonteCarloIntegrator::isAccepted(double energyChange)
{
    return energyChange <= 0 || random->drawUniform() < exp(-energyChange / (BOLTZ * temperature));
}

void TorsionMonteCarloIntegrator::step(int steps)
{
    if (context == NULL)
        throw OpenMMException("This Integrator is not bound to a context!");
    double weightSum = sumWeights();
    force->takeNoticeOfPositions(*context);
    for (int i = 0; i < steps; i++) {
        context->updateContextState();
        if (stericMode == Soft)
            force->beginTrialsWithoutLimits(*context);
        else {
            force->beginTrials(*context);
            if (initialClashPolicy == Refuse)
                force->refuseToleratedClashes();
        }
        try {
            runTrials(weightSum);
        }
        catch (...) {
            force->finishTrials(*context);
            throw;
        }
        context->setTime(context->getTime() + getStepSize());
        context->setStepCount(context->getStepCount() + 1);
        force->finishTrials(*context);
    }
}

/**
 * Run the trials of one step. Only the kernel's state follows them.
 */
void TorsionMonteCarloIntegrator::runTrials(double weightSum)
{
    CalcStericExclusionForceKernel& kernel = force->getKernel();
    const int groups = getIntegrationForceGroups() & groupsWithEnergy;
    double energy = groups == 0 ? 0 : force->computeOtherEnergy(*context, groups);
    if (!isEnergy(energy))
        fail("the energy of the integration force groups is not a number");
    for (int i = 0; i < trialsPerStep; i++) {
        MoveInfo& info = drawMove(weightSum);
        info.move->propose(kernel, *random);
        if (stericMode == Hard && !kernel.isProposalFree()) {
            kernel.rejectProposal();
            info.clashed++;
            continue;
        }
        double newEnergy = 0;
        if (groups != 0) {
            force->showProposal(*context);
            newEnergy = force->computeOtherEnergy(*context, groups);
        }
        double change = newEnergy == energy ? 0 : newEnergy - energy; // Both may be infinite.
        if (stericMode == Soft)
            change += kernel.getProposedEnergyChange();
        if (!isEnergy(newEnergy) || !isAccepted(change)) {
            kernel.rejectProposal();
            info.rejectedByEnergy++;
            continue;
        }
        energy = newEnergy;
        kernel.acceptProposal();
        info.accepted++;
    }
}
