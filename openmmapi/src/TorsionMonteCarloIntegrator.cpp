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
#include "openmmchaintree/internal/ContextSnapshot.h"
#include "openmmchaintree/internal/Hexadecimal.h"
#include "openmmchaintree/internal/MonteCarloMove.h"
#include "openmmchaintree/internal/RandomNumberGenerator.h"
#include "openmmchaintree/internal/StericExclusionForceImpl.h"
#include <algorithm>
#include <cmath>
#include <limits>
#include <sstream>

using namespace ChainTreePlugin;
using namespace OpenMM;
using namespace std;

/** What the integrator's part of a checkpoint begins with: "ChainTMC" where the first byte is the lowest. */
static const uint64_t CHECKPOINT_MARK = 0x434d546e69616843;

static const int CHECKPOINT_VERSION = 2;

static const int NEWEST_STATE_VERSION = 2;

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
    /**
     * Get what decides the trials of this move, among others.
     */
    MoveDescription describe() const
    {
        MoveDescription description = move->describe();
        description.insert(description.begin() + 1, {"weight", toText(weight)});
        return description;
    }
    unique_ptr<MonteCarloMove> move;
    double weight;
    long long clashed, rejectedByEnergy, accepted;
};

/**
 * What a Context held when its reinitialize() began, as far as OpenMM does not keep it: if a Force or this integrator
 * refuses, the checkpoint that reinitialize() made is lost.
 */
class TorsionMonteCarloIntegrator::KeptState {
public:
    ContextSnapshot context;
    vector<int> structure;
    string random;
    /** The part of a checkpoint that is the force's. */
    string geometry;
    /** Whether the user has set positions since. */
    bool positionsWereSet;
    /** Whether the incomplete Context that there is now was given the positions. */
    bool isShown;
};

/** Whether a checkpoint is of a Context that was not complete, and holds what was kept. */
enum CheckpointForm : uint8_t { OfCompleteContext = 0, OfKeptState = 1, OfKeptStateWithNewPositions = 2 };

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

/**
 * Throw an exception if an angle is more than any move needs. Mostly it is one in degrees.
 */
static void checkLargestAngle(double angle, const string& kind)
{
    string name = "the largest angle of a " + kind + " move";
    checkNotNegative(angle, "TorsionMonteCarloIntegrator: " + name);
    const double rounding = 1e-9; // of a half turn that was computed
    if (angle > M_PI * (1 + rounding)) {
        stringstream message;
        message << name << " must be at most pi, half a turn, but is " << angle << " radians; " << angle
                << " degrees are " << angle * M_PI / 180 << " radians (in Python " << angle << "*unit.degrees)";
        fail(message.str());
    }
}

static unique_ptr<MonteCarloMove> makeTorsionMove(double maxAngle, const vector<int>& torsions, int count)
{
    checkLargestAngle(maxAngle, "torsion");
    if (count < 1)
        fail("the number of torsions that a move turns must be at least 1, but is " + to_string(count));
    return make_unique<TorsionMove>(maxAngle, torsions, count);
}

static unique_ptr<MonteCarloMove> makeRigidBodyMove(double maxTranslation, double maxAngle,
                                                    const vector<int>& molecules)
{
    checkNotNegative(maxTranslation, "TorsionMonteCarloIntegrator: the largest translation of a rigid body move");
    checkLargestAngle(maxAngle, "rigid body");
    return make_unique<RigidBodyMove>(maxTranslation, maxAngle, molecules);
}

int TorsionMonteCarloIntegrator::addTorsionMove(double weight, double maxAngle, const vector<int>& torsions, int count)
{
    return addMove(makeTorsionMove(maxAngle, torsions, count), weight);
}

int TorsionMonteCarloIntegrator::addRigidBodyMove(double weight, double maxTranslation, double maxAngle,
                                                  const vector<int>& molecules)
{
    return addMove(makeRigidBodyMove(maxTranslation, maxAngle, molecules), weight);
}

int TorsionMonteCarloIntegrator::addMove(unique_ptr<MonteCarloMove> move, double weight)
{
    checkNotNegative(weight, "TorsionMonteCarloIntegrator: the weight of a move");
    if (force != NULL)
        move->bind(force->getLinkStructure(), describeMove(moves.size()));
    moves.push_back(MoveInfo(std::move(move), weight));
    return moves.size() - 1;
}

/**
 * Put another move of the same kind in the place of one.
 */
void TorsionMonteCarloIntegrator::setMove(int index, unique_ptr<MonteCarloMove> move, double weight)
{
    checkNotNegative(weight, "TorsionMonteCarloIntegrator: the weight of a move");
    if (force != NULL)
        move->bind(force->getLinkStructure(), describeMove(index));
    moves[index] = MoveInfo(std::move(move), weight);
}

void TorsionMonteCarloIntegrator::setTorsionMoveParameters(int move, double weight, double maxAngle,
                                                           const vector<int>& torsions, int count)
{
    double formerWeight;
    getMove<ChainTreePlugin::TorsionMove>(move, formerWeight, "torsion");
    setMove(move, makeTorsionMove(maxAngle, torsions, count), weight);
}

void TorsionMonteCarloIntegrator::setRigidBodyMoveParameters(int move, double weight, double maxTranslation,
                                                             double maxAngle, const vector<int>& molecules)
{
    double formerWeight;
    getMove<ChainTreePlugin::RigidBodyMove>(move, formerWeight, "rigid body");
    setMove(move, makeRigidBodyMove(maxTranslation, maxAngle, molecules), weight);
}

void TorsionMonteCarloIntegrator::removeMove(int move)
{
    ASSERT_VALID_INDEX(move, moves);
    moves.erase(moves.begin() + move);
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

/**
 * Throw an exception unless there is a complete Context.
 */
void TorsionMonteCarloIntegrator::requireBound() const
{
    if (force != NULL)
        return;
    if (owner == NULL)
        throw OpenMMException("This Integrator is not bound to a context!");
    fail("its Context is not complete, because reinitialize() was refused; mend what the exception named and call "
         "reinitialize() again");
}

void TorsionMonteCarloIntegrator::requireContext(const Context& context) const
{
    if (owner == &context)
        requireBound();
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

// ---- Life in a Context ----

void TorsionMonteCarloIntegrator::initialize(ContextImpl& contextRef)
{
    if (owner != NULL && &contextRef.getOwner() != owner)
        throw OpenMMException("This Integrator is already bound to a context");

    // This kernel is never executed, but on GPUs only an integrator's kernel initializes what a Context needs.

    Kernel created = contextRef.getPlatform().createKernel(IntegrateVerletStepKernel::Name(), contextRef);
    created.getAs<IntegrateVerletStepKernel>().initialize(contextRef.getSystem(), VerletIntegrator(getStepSize()));
    try {
        bindTo(contextRef);
    }
    catch (...) {
        showKeptState();
        throw;
    }
    kernel = created;
    kept.reset();
}

/**
 * Take possession of a Context, or throw an exception that says why this integrator cannot drive it.
 */
void TorsionMonteCarloIntegrator::bindTo(ContextImpl& contextRef)
{
    const System& system = contextRef.getSystem();
    StericExclusionForceImpl& found = findForce(contextRef);
    checkNoBarostat(system);
    checkConstraints(system, found.getLinkStructure());
    for (size_t i = 0; i < moves.size(); i++)
        moves[i].move->bind(found.getLinkStructure(), describeMove(i));
    random.reset(new RandomNumberGenerator(randomNumberSeed == 0 ? osrngseed() : randomNumberSeed));
    found.expectDynamics(!hasSilentSteps(contextRef.getIntegrator()));
    groupsWithEnergy = findGroupsWithEnergy(system);
    force = &found;
    forceLife = found.getLife();
    context = &contextRef;
    owner = &contextRef.getOwner();
}

void TorsionMonteCarloIntegrator::cleanup()
{
    // A Context that is reinitialized is whole at this time; of one that ends the forces are gone.

    if (force != NULL && !forceLife.expired())
        kept = keepState();
    if (kept)
        kept->isShown = false;
    force = NULL;
    context = NULL;
    random.reset();
    kernel = Kernel();
    restoredPositions.clear();
}

/**
 * Get all that is needed to go on in a Context made anew.
 */
unique_ptr<TorsionMonteCarloIntegrator::KeptState> TorsionMonteCarloIntegrator::keepState()
{
    bool positionsAreSet = true;
    try {
        context->calcForcesAndEnergy(false, false, 0);
    }
    catch (const OpenMMException&) {
        positionsAreSet = false;
    }
    stringstream geometry;
    CheckpointWriter writer(geometry);
    force->createCheckpoint(writer);
    return unique_ptr<KeptState>(new KeptState{ContextSnapshot(context->getOwner(), positionsAreSet),
                                               force->getLinkStructure().describe(), random->getState(), geometry.str(),
                                               false, false});
}

/**
 * Give an incomplete Context what was kept of its predecessor. This also makes OpenMM know that positions were set,
 * which it carries over from there.
 */
void TorsionMonteCarloIntegrator::showKeptState() const
{
    if (!kept || kept->isShown)
        return;
    kept->isShown = true;
    ContextSnapshot(kept->context).restore(*owner);
}

vector<string> TorsionMonteCarloIntegrator::getKernelNames()
{
    return {IntegrateVerletStepKernel::Name()};
}

void TorsionMonteCarloIntegrator::stateChanged(State::DataType changed)
{
    if (kept && changed == State::Positions)
        kept->positionsWereSet |= kept->context.updatePositions(*owner);
    if (kept && changed == State::Velocities)
        kept->context.updateVelocities(*owner);
    if (force == NULL || changed != State::Positions)
        return;
    vector<Vec3> restored;
    restored.swap(restoredPositions);
    force->positionsWereSet(*context, restored);
}

// ---- Checkpoints ----

void TorsionMonteCarloIntegrator::writeMoves(CheckpointWriter& writer) const
{
    writer.write((uint64_t)moves.size());
    for (const MoveInfo& info : moves) {
        MoveDescription description = info.describe();
        writer.write((uint64_t)description.size());
        for (auto& property : description) {
            writer.write(property.first);
            writer.write(property.second);
        }
        writer.write(vector<long long>({info.clashed, info.rejectedByEnergy, info.accepted}));
    }
}

/**
 * Throw an exception that says how a move differs from that of a checkpoint, if it does.
 */
static void checkSameMove(size_t index, const MoveDescription& written, const MoveDescription& own)
{
    const size_t longest = 40; // that a message can show
    for (size_t i = 0; i < min(written.size(), own.size()); i++) {
        if (written[i] == own[i])
            continue;
        const string &name = own[i].first, &value = written[i].second, &ownValue = own[i].second;
        bool isShort = (value.size() <= longest && ownValue.size() <= longest);
        fail("the checkpoint is of other moves: move " + to_string(index) + " has " +
             (isShort ? name + " " + value + " in it, but " + ownValue + " here"
                      : "other " + name + " in it than here") +
             "; give this integrator the moves of the checkpoint, and change them after it is loaded");
    }
}

/**
 * Read the moves of a checkpoint and get their counts, three of each. It is an error if they are not those of this
 * integrator.
 */
vector<long long> TorsionMonteCarloIntegrator::readMoves(CheckpointReader& reader) const
{
    uint64_t count = reader.read<uint64_t>();
    if (count != moves.size())
        fail("the checkpoint is of an integrator with " + to_string(count) + " moves, but this one has " +
             to_string(moves.size()));
    vector<long long> statistics;
    for (size_t i = 0; i < moves.size(); i++) {
        MoveDescription description;
        uint64_t size = reader.read<uint64_t>();
        for (uint64_t j = 0; j < size; j++) {
            string name = reader.readString();
            description.push_back(make_pair(name, reader.readString()));
        }
        checkSameMove(i, description, moves[i].describe());
        for (long long number : reader.readVector<long long>())
            statistics.push_back(number);
    }
    return statistics;
}

void TorsionMonteCarloIntegrator::createCheckpoint(ostream& stream) const
{
    if (!kept)
        requireBound();
    CheckpointWriter writer(stream);
    writer.write(CHECKPOINT_MARK);
    writer.write(CHECKPOINT_VERSION);
    writer.write(force != NULL ? force->getLinkStructure().describe() : kept->structure);
    writeMoves(writer);
    if (force != NULL) {
        writer.write(random->getState());
        writer.write(OfCompleteContext);
        force->createCheckpoint(writer);
        return;
    }
    showKeptState();
    writer.write(kept->random);
    writer.write(kept->positionsWereSet ? OfKeptStateWithNewPositions : OfKeptState);
    kept->context.write(writer);
    writer.append(kept->geometry);
}

void TorsionMonteCarloIntegrator::loadCheckpoint(istream& stream)
{
    requireBound();
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
    int version = reader.read<int>();
    if (version != CHECKPOINT_VERSION)
        throw OpenMMException("the checkpoint of a TorsionMonteCarloIntegrator has version " + to_string(version) +
                              ", but this openmm-chaintree reads only version " + to_string(CHECKPOINT_VERSION));
    if (reader.readVector<int>() != force->getLinkStructure().describe())
        fail("the checkpoint is of another structure: its bonds and torsions make other links");
    vector<long long> statistics = readMoves(reader);
    RandomNumberGenerator restored(0);
    bool isGood = restored.setState(reader.readString());
    CheckpointForm form = reader.read<CheckpointForm>();
    if (!isGood || statistics.size() != 3 * moves.size() || form > OfKeptStateWithNewPositions)
        fail("the checkpoint is damaged");
    if (form != OfCompleteContext)
        ContextSnapshot(reader).restore(context->getOwner());
    force->loadCheckpoint(reader);
    if (form != OfKeptStateWithNewPositions)
        context->getPositions(restoredPositions);
    *random = restored;
    for (size_t i = 0; i < moves.size(); i++) {
        moves[i].clashed = statistics[3 * i];
        moves[i].rejectedByEnergy = statistics[3 * i + 1];
        moves[i].accepted = statistics[3 * i + 2];
    }
}

// ---- States ----

/**
 * Get a text that tells positions from others, by their bits (FNV-1a).
 */
static string fingerprint(const vector<Vec3>& positions)
{
    uint64_t hash = 0xcbf29ce484222325;
    const unsigned char* bytes = reinterpret_cast<const unsigned char*>(positions.data());
    for (size_t i = 0; i < positions.size() * sizeof(Vec3); i++)
        hash = (hash ^ bytes[i]) * 0x100000001b3;
    return to_string(hash);
}

void TorsionMonteCarloIntegrator::serializeParameters(SerializationNode& node) const
{
    requireBound();
    node.setIntProperty("version", NEWEST_STATE_VERSION);
    SerializationNode& moveList = node.createChildNode("Moves");
    for (const MoveInfo& info : moves) {
        SerializationNode& move = moveList.createChildNode("Move");
        for (auto& property : info.describe())
            move.setStringProperty(property.first, property.second);
        move.setLongProperty("clashed", info.clashed)
            .setLongProperty("rejectedByEnergy", info.rejectedByEnergy)
            .setLongProperty("accepted", info.accepted);
    }
    node.createChildNode("Random").setStringProperty("state", random->getState());
    vector<Vec3> positions;
    context->getPositions(positions);
    stringstream geometry;
    CheckpointWriter writer(geometry);
    writer.write(force->getLinkStructure().describe());
    force->createCheckpoint(writer);
    node.createChildNode("Geometry")
        .setStringProperty("positions", fingerprint(positions))
        .setStringProperty("data", toHexadecimal(geometry.str()));
    vector<pair<int, int>> pairs;
    vector<double> limits;
    force->getLimits(pairs, limits);
    SerializationNode& limitList = node.createChildNode("Limits");
    for (size_t i = 0; i < pairs.size(); i++)
        limitList.createChildNode("Limit")
            .setIntProperty("p1", pairs[i].first)
            .setIntProperty("p2", pairs[i].second)
            .setDoubleProperty("overlap", limits[i]);
}

/**
 * Restore the counts of the moves from a State, if it is of the same moves.
 */
void TorsionMonteCarloIntegrator::deserializeStatistics(const vector<SerializationNode>& nodes)
{
    if (nodes.size() != moves.size())
        return;
    for (size_t i = 0; i < moves.size(); i++)
        for (auto& property : moves[i].describe())
            if (nodes[i].getStringProperty(property.first, "") != property.second)
                return;
    for (size_t i = 0; i < moves.size(); i++) {
        moves[i].clashed = nodes[i].getLongProperty("clashed");
        moves[i].rejectedByEnergy = nodes[i].getLongProperty("rejectedByEnergy");
        moves[i].accepted = nodes[i].getLongProperty("accepted");
    }
}

/**
 * Restore what the geometry is computed from, and the limits. Returns false, and changes nothing, if the Context does
 * not stand where that State was made, or has another structure.
 */
bool TorsionMonteCarloIntegrator::deserializeGeometry(const SerializationNode& node)
{
    vector<Vec3> positions;
    context->getPositions(positions);
    if (fingerprint(positions) != node.getStringProperty("positions"))
        return false;
    string data;
    if (!fromHexadecimal(node.getStringProperty("data"), data))
        fail("the State is damaged");
    stringstream stream(data);
    CheckpointReader reader(stream);
    if (reader.readVector<int>() != force->getLinkStructure().describe())
        return false;
    try {
        force->loadCheckpoint(reader);
    }
    catch (...) {
        force->restartLimits();
        throw;
    }
    return true;
}

void TorsionMonteCarloIntegrator::deserializeParameters(const SerializationNode& node)
{
    requireBound();

    // Many integrators keep nothing in a State. Sampling may well start from what they have made.

    if (!node.hasProperty("version"))
        return;
    auto& children = node.getChildren();
    bool isOurs = any_of(children.begin(), children.end(), [](const SerializationNode& child) {
        return child.getName() == "Limits";
    });
    if (!isOurs)
        fail("the integrator parameters of the State are those of another Integrator");
    int version = node.getIntProperty("version");
    checkVersion(version, NEWEST_STATE_VERSION, "the State of a TorsionMonteCarloIntegrator");
    vector<pair<int, int>> pairs;
    vector<double> limits;
    for (auto& limit : node.getChildNode("Limits").getChildren()) {
        pairs.push_back(make_pair(limit.getIntProperty("p1"), limit.getIntProperty("p2")));
        limits.push_back(limit.getDoubleProperty("overlap"));
    }
    if (version == 1) {
        force->setLimits(*context, pairs, limits);
        return;
    }
    RandomNumberGenerator restored(0);
    if (!restored.setState(node.getChildNode("Random").getStringProperty("state")))
        fail("the State is damaged");
    if (!deserializeGeometry(node.getChildNode("Geometry")))
        force->setLimits(*context, pairs, limits);
    *random = restored;
    deserializeStatistics(node.getChildNode("Moves").getChildren());
}

// ---- Sampling ----

double TorsionMonteCarloIntegrator::computeKineticEnergy()
{
    requireBound();
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
    requireBound();
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
