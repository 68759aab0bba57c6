#include "openmmchaintree/TorsionMonteCarloIntegrator.h"
#include "openmm/internal/ContextImpl.h"
#include "openmm/internal/OSRngSeed.h"
#include "openmm/kernels.h"
#include "openmm/OpenMMException.h"
#include "openmm/reference/SimTKOpenMMRealType.h"
#include "openmm/serialization/SerializationNode.h"
#include "openmm/VerletIntegrator.h"
#include "openmmchaintree/internal/ArgumentChecks.h"
#include "openmmchaintree/internal/CheckpointStream.h"
#include "openmmchaintree/internal/ContextLock.h"
#include "openmmchaintree/internal/ContextSnapshot.h"
#include "openmmchaintree/internal/EnergyStage.h"
#include "openmmchaintree/internal/Fingerprint.h"
#include "openmmchaintree/internal/Hexadecimal.h"
#include "openmmchaintree/internal/Interpreter.h"
#include "openmmchaintree/internal/KeptGeometry.h"
#include "openmmchaintree/internal/MonteCarloMove.h"
#include "openmmchaintree/internal/MoveList.h"
#include "openmmchaintree/internal/NativeEnergy.h"
#include "openmmchaintree/internal/OuterTest.h"
#include "openmmchaintree/internal/RandomNumberGenerator.h"
#include "openmmchaintree/internal/StateNumber.h"
#include "openmmchaintree/internal/StateSeal.h"
#include "openmmchaintree/internal/StericExclusionForceImpl.h"
#include "openmmchaintree/internal/SystemChecks.h"
#include "openmmchaintree/internal/TrialSession.h"
#include "openmmchaintree/internal/Warnings.h"
#include <algorithm>
#include <cmath>
#include <limits>
#include <sstream>

using namespace ChainTreePlugin;
using namespace OpenMM;
using namespace std;

/** The first bytes of the integrator's part of a checkpoint: "ChainTMC" on little-endian machines. */
static const uint64_t CHECKPOINT_MARK = 0x434d546e69616843;

/** From version 5 on checkpoints have checksums and the schedule of outer tests. */
static const int CHECKPOINT_VERSION = 5, OLDEST_CHECKPOINT_VERSION = 4;

/** The first bytes of OpenMM's part of a checkpoint. */
static const char OPENMM_MARK[] = "OpenMM Binary Checkpoint\n";

/** From version 4 on States have checksums. */
static const int NEWEST_STATE_VERSION = 4;

static void fail(const string& message)
{
    throw OpenMMException("TorsionMonteCarloIntegrator: " + message);
}

/**
 * The state of a Context whose reinitialize() has begun. If a Force or this integrator throws an exception there,
 * OpenMM's own checkpoint is lost.
 */
class TorsionMonteCarloIntegrator::KeptState {
public:
    ContextSnapshot context;
    vector<int> structure;
    string random;
    vector<double> standIn, schedule;
    /** The force's part of a checkpoint. */
    string geometry;
    /** Whether the user has set positions since. */
    bool positionsWereSet;
    /** Whether the present, incomplete Context was given the positions. */
    bool isShown;
};

/** Whether a checkpoint is of a complete Context, or holds the KeptState of an incomplete one. */
enum CheckpointForm : uint8_t { OfCompleteContext = 0, OfKeptState = 1, OfKeptStateWithNewPositions = 2 };

TorsionMonteCarloIntegrator::TorsionMonteCarloIntegrator(double temperature) :
    moves(new MoveList()), adaptMoveSizes(false), trialsPerStep(100), initialClashPolicy(Tolerate),
    stericMode(Automatic), nativeEnergies(true), trialsPerOuterTest(0), outerStatistics(new OuterStatistics()),
    lock(make_shared<ContextLock>()), secondsPerTrial(numeric_limits<double>::infinity()), force(NULL),
    isBesideDynamics(false), hasWarnedOfHardSpheres(false), constraintsAreChecked(false)
{
    const EnergyTerms::StandIn usual;
    setStandInCutoffs(usual.bornCutoff, usual.pairCutoff);
    setStandInGridWidth(usual.gridWidth);
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
    if (mode < Hard || mode > Automatic)
        fail("the steric mode must be Automatic, Off, Hard or Soft, but is " + to_string((int)mode));
    ContextUse use(lock, ContextLock::User);
    const bool wereOff = hasSpheresOff();
    stericMode = mode;
    if (force != NULL && hasSpheresOff() != wereOff)
        context->systemChanged(); // the energy of the force is another
}

TorsionMonteCarloIntegrator::StericMode TorsionMonteCarloIntegrator::getStericModeInContext(Context& context) const
{
    ContextUse use(lock, ContextLock::User);
    requireContext(context);
    return native->getStericMode();
}

bool TorsionMonteCarloIntegrator::displacesParticles() const
{
    return moves->displaceParticles();
}

double TorsionMonteCarloIntegrator::getAtomMoveShare() const
{
    return moves->getDisplacingShare();
}

bool TorsionMonteCarloIntegrator::hasSpheresOff() const
{
    return (native ? native->getStericMode() : stericMode) == Off;
}

int TorsionMonteCarloIntegrator::getNumToleratedClashes(Context& context) const
{
    ContextUse use(lock, ContextLock::User);
    requireContext(context);
    return force->queryState(*this->context).getNumLimits();
}

// ---- Moves. Each kind is in its own file ----

int TorsionMonteCarloIntegrator::addMove(unique_ptr<MonteCarloMove> move, double weight)
{
    ContextUse use(lock, ContextLock::User);
    return moves->add(std::move(move), weight);
}

void TorsionMonteCarloIntegrator::setMove(int index, unique_ptr<MonteCarloMove> move, double weight)
{
    ContextUse use(lock, ContextLock::User);
    moves->requireKind(index, move->getKind());
    moves->set(index, std::move(move), weight);
}

void TorsionMonteCarloIntegrator::removeMove(int move)
{
    ContextUse use(lock, ContextLock::User);
    moves->remove(move);
}

int TorsionMonteCarloIntegrator::getNumMoves() const
{
    return moves->size();
}

TorsionMonteCarloIntegrator::MoveType TorsionMonteCarloIntegrator::getMoveType(int move) const
{
    return moves->get(move).move->getKind().type;
}

string TorsionMonteCarloIntegrator::getMoveDescription(int move) const
{
    return moves->summarize(move);
}

void TorsionMonteCarloIntegrator::getMoveStatistics(int move, long long& attempted, long long& clashed,
                                                    long long& rejectedByEnergy, long long& accepted) const
{
    ContextUse use(lock, ContextLock::User);
    const MoveList::Counts& counts = moves->get(move).counts;
    attempted = counts.impossible + counts.clashed + counts.rejectedByEnergy + counts.accepted;
    clashed = counts.clashed;
    rejectedByEnergy = counts.rejectedByEnergy;
    accepted = counts.accepted;
}

void TorsionMonteCarloIntegrator::resetMoveStatistics()
{
    ContextUse use(lock, ContextLock::User);
    resetStatistics();
}

void TorsionMonteCarloIntegrator::resetStatistics()
{
    moves->resetStatistics();
    *outerStatistics = OuterStatistics();
    if (stages)
        stages->resetStatistics();
}

bool TorsionMonteCarloIntegrator::getAdaptMoveSizes() const
{
    return adaptMoveSizes;
}

void TorsionMonteCarloIntegrator::setAdaptMoveSizes(bool adapt)
{
    if (adapt == adaptMoveSizes)
        return;
    ContextUse use(lock, ContextLock::User);
    adaptMoveSizes = adapt;
    moves->restartAdaptation();
    resetStatistics();
}

double TorsionMonteCarloIntegrator::getMoveScale(int move) const
{
    const vector<double>& scales = moves->get(move).move->getScales();
    double sum = 0;
    for (double scale : scales)
        sum += log(scale);
    return scales.size() == 1 ? scales[0] : exp(sum / scales.size());
}

void TorsionMonteCarloIntegrator::setMoveScale(int move, double scale)
{
    ContextUse use(lock, ContextLock::User);
    moves->setScale(move, scale);
}

void TorsionMonteCarloIntegrator::getMoveScales(int move, vector<double>& scales) const
{
    scales = moves->get(move).move->getScales();
}

void TorsionMonteCarloIntegrator::setMoveScales(int move, const vector<double>& scales)
{
    ContextUse use(lock, ContextLock::User);
    moves->setScales(move, scales);
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
    if (contextHasEnded)
        fail("its Context was deleted; an Integrator serves one Context, so make a new one of both");
    fail("its Context is not complete, because reinitialize() threw an exception; correct its cause and call "
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
    ContextUse use(lock, ContextLock::User);
    requireContext(context);
    force->getTorsionAngles(*this->context, angles);
}

void TorsionMonteCarloIntegrator::setTorsionAngles(Context& context, const vector<double>& angles) const
{
    ContextUse use(lock, ContextLock::User);
    requireContext(context);
    force->setTorsionAngles(*this->context, angles);
}

void TorsionMonteCarloIntegrator::checkVelocities(Context& context) const
{
    ContextUse use(lock, ContextLock::User);
    requireContext(context);
    VelocityTurner& velocities = force->getVelocityTurner();
    if (velocities.findVelocities(*this->context))
        velocities.requireTurnable();
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
        moves->bind(NULL);
        stages.reset();
        native.reset();
        showKeptState();
        throw;
    }
    kernel = created;
    kept.reset();
}

/**
 * Bind to a Context, or throw an exception that says why this integrator cannot sample it.
 */
void TorsionMonteCarloIntegrator::bindTo(ContextImpl& contextRef)
{
    const System& system = contextRef.getSystem();
    StericExclusionForceImpl& found = findStericExclusionForce(contextRef);
    checkConstraints(system, found.getLinkStructure());
    isBesideDynamics = hasDynamics(contextRef.getIntegrator());
    if (isBesideDynamics)
        found.getVelocityTurner().requireTurnable();
    else
        found.getVelocityTurner().expectNoDynamics();
    hasWarnedOfHardSpheres = false;
    constraintsAreChecked = false;
    moves->bind(&found.getLinkStructure());
    random.reset(new RandomNumberGenerator(randomNumberSeed == 0 ? osrngseed() : randomNumberSeed));
    found.getLimitPolicy().expectDynamics(!hasSilentSteps(contextRef.getIntegrator()));
    bindEnergies(found, contextRef);
    if (native->getStericMode() == Hard)
        checkHardSpheres(system);
    if (moves->changeVolume())
        checkVolumeMoves(system, temperature);
    lock = found.getLock();
    force = &found;
    forceLife = found.getLife();
    context = &contextRef;
    owner = &contextRef.getOwner();
}

void TorsionMonteCarloIntegrator::cleanup()
{
    // A Context that is reinitialized is still complete here; if it ends, its forces are gone.

    const bool isWhole = (force != NULL && !forceLife.expired());
    const unique_ptr<ContextUse> use(isWhole ? new ContextUse(lock, ContextLock::User) : NULL);
    if (isWhole)
        kept = keepState();
    else if (force != NULL)
        contextHasEnded = true;
    if (kept)
        kept->isShown = false;
    force = NULL;
    context = NULL;
    moves->bind(NULL);
    stages.reset();
    native.reset();
    random.reset();
    kernel = Kernel();
    restoredPositions.clear();
}

/**
 * Get everything that a recreated Context needs to continue.
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
                                               force->describeStructure(), random->getState(), native->getStandIn(),
                                               native->getSchedule(), geometry.str(), false, false});
}

/**
 * Give an incomplete Context the state of its predecessor. OpenMM then knows that positions were set, and copies this
 * to the next Context.
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
    ContextUse use(lock, ContextLock::OpenMM);
    if (kept && changed == State::Positions)
        kept->positionsWereSet |= kept->context.updatePositions(*owner);
    if (kept && changed == State::Velocities)
        kept->context.updateVelocities(*owner);
    if (native)
        native->contextWasChanged(changed);
    if (force != NULL && changed == State::Velocities)
        force->getVelocityTurner().velocitiesWereSet();
    if (force == NULL || changed != State::Positions)
        return;
    vector<Vec3> restored;
    restored.swap(restoredPositions);
    force->positionsWereSet(*context, restored);
}

// ---- Checkpoints ----

/**
 * Get OpenMM's part of a checkpoint, which is already written; empty if the stream cannot be read.
 */
static string getWrittenBefore(const ostream& stream)
{
    const stringbuf* buffer = dynamic_cast<const stringbuf*>(stream.rdbuf());
    if (buffer == NULL)
        return "";
    const string written = buffer->str();
    const size_t begin = written.rfind(OPENMM_MARK);
    return begin == string::npos ? "" : written.substr(begin);
}

/**
 * Throw an exception if OpenMM's part of a checkpoint has another checksum.
 *
 * @param begin  the end of OpenMM's part in the stream
 */
static void checkReadBefore(istream& stream, streamoff begin, uint64_t size, uint64_t hash)
{
    string bytes;
    if (size <= (uint64_t)begin) {
        const streampos here = stream.tellg();
        bytes.resize(size);
        stream.seekg(begin - (streamoff)size);
        stream.read(&bytes[0], size);
        stream.seekg(here);
    }
    if (!stream || bytes.empty() || hashBytes(bytes.data(), bytes.size()) != hash)
        fail("the checkpoint is damaged: OpenMM's part has another checksum");
}

void TorsionMonteCarloIntegrator::createCheckpoint(ostream& stream) const
{
    ContextUse use(lock, ContextLock::User);
    if (!kept)
        requireBound();
    const string before = getWrittenBefore(stream);
    stringstream own;
    CheckpointWriter writer(own), all(stream);
    writer.write(force != NULL ? force->describeStructure() : kept->structure);
    moves->createCheckpoint(writer);
    outerStatistics->write(writer);
    if (force != NULL) {
        native->recompute();
        writer.write(random->getState());
        writer.write(native->getStandIn());
        writer.write(OfCompleteContext);
        force->createCheckpoint(writer);
        writer.write(native->getSchedule());
    }
    else {
        showKeptState();
        writer.write(kept->random);
        writer.write(kept->standIn);
        writer.write(kept->positionsWereSet ? OfKeptStateWithNewPositions : OfKeptState);
        kept->context.write(writer);
        writer.append(kept->geometry);
        writer.write(kept->schedule);
    }
    all.write(CHECKPOINT_MARK);
    all.write(CHECKPOINT_VERSION);
    all.write((uint64_t)before.size());
    all.write(hashBytes(before.data(), before.size()));
    all.writeSealed(own.str());
}

void TorsionMonteCarloIntegrator::loadCheckpoint(istream& stream)
{
    ContextUse use(lock, ContextLock::User);
    requireBound();
    const streamoff begin = stream.tellg(); // -1 if the stream cannot be read again
    CheckpointReader reader(stream);
    try {
        if (reader.read<uint64_t>() != CHECKPOINT_MARK)
            fail("the checkpoint was created with another Integrator");
        const int version = reader.read<int>();
        checkVersion(version, CHECKPOINT_VERSION, "the checkpoint of a TorsionMonteCarloIntegrator",
                     OLDEST_CHECKPOINT_VERSION);
        if (version < 5) {
            restoreCheckpoint(reader, version, false);
            return;
        }
        const uint64_t size = reader.read<uint64_t>(), hash = reader.read<uint64_t>();
        stringstream own(reader.readSealed());
        const bool isCovered = size > 0 && begin != -1;
        if (isCovered)
            checkReadBefore(stream, begin, size, hash);
        CheckpointReader ownReader(own);
        restoreCheckpoint(ownReader, version, isCovered);
    }
    catch (...) {
        // The Context has the checkpoint's positions already.

        force->getLimitPolicy().restart();
        throw;
    }
}

/**
 * Read and check the whole checkpoint before using any of it.
 *
 * @param positionsAreSafe  whether a checksum has shown that the Context has the positions of the checkpoint
 */
void TorsionMonteCarloIntegrator::restoreCheckpoint(CheckpointReader& reader, int version, bool positionsAreSafe)
{
    if (reader.readVector<int>() != force->describeStructure())
        fail("the checkpoint is of another structure: its bonds and torsions make other links, or only one of the two "
             "uses periodic boundary conditions or has atom moves");
    const MoveList::Progress progress = moves->readCheckpoint(reader);
    OuterStatistics restoredTests;
    restoredTests.read(reader);
    RandomNumberGenerator restored(0);
    bool isGood = restored.setState(reader.readString());
    vector<double> standIn = reader.readVector<double>();
    CheckpointForm form = reader.read<CheckpointForm>();
    if (!isGood || form > OfKeptStateWithNewPositions || !NativeEnergy::isStandIn(standIn))
        fail("the checkpoint is damaged");
    unique_ptr<ContextSnapshot> snapshot;
    if (form != OfCompleteContext)
        snapshot.reset(new ContextSnapshot(reader));
    const KeptGeometry geometry(reader);
    const vector<double> schedule = version < 5 ? vector<double>() : reader.readVector<double>();
    force->checkCheckpoint(*context, geometry);
    if (!positionsAreSafe && form == OfCompleteContext)
        force->havePositionsOf(*context, geometry);
    if (snapshot)
        snapshot->restore(context->getOwner());
    force->loadCheckpoint(geometry);
    if (form != OfKeptStateWithNewPositions)
        context->getPositions(restoredPositions);
    *random = restored;
    moves->setProgress(progress);
    *outerStatistics = restoredTests;
    native->setStandIn(standIn);
    native->setSchedule(schedule);
}

// ---- States ----

static string fingerprintOf(const vector<Vec3>& positions)
{
    return fingerprint(positions.data(), positions.size() * sizeof(Vec3));
}

void TorsionMonteCarloIntegrator::serializeParameters(SerializationNode& node) const
{
    ContextUse use(lock, ContextLock::User);
    requireBound();
    native->recompute();
    node.setIntProperty("version", NEWEST_STATE_VERSION);
    moves->writeProgress(node.createChildNode("Moves"));
    node.createChildNode("Random").setStringProperty("state", random->getState());
    vector<Vec3> positions;
    context->getPositions(positions);
    stringstream geometry;
    CheckpointWriter writer(geometry);
    writer.write(force->describeStructure());
    force->createCheckpoint(writer);
    node.createChildNode("Geometry")
        .setStringProperty("positions", fingerprintOf(positions))
        .setStringProperty("data", toHexadecimal(geometry.str()));
    outerStatistics->write(node.createChildNode("OuterTests"));
    native->writeStandIn(node.createChildNode("StandIn"));
    writeTraits(node.createChildNode("Context"), *context);
    vector<pair<int, int>> pairs;
    vector<double> limits;
    force->getLimits(pairs, limits);
    SerializationNode& limitList = node.createChildNode("Limits");
    for (size_t i = 0; i < pairs.size(); i++) {
        SerializationNode& limit = limitList.createChildNode("Limit");
        limit.setIntProperty("p1", pairs[i].first).setIntProperty("p2", pairs[i].second);
        setNumber(limit, "overlap", limits[i]);
    }
    seal(node);
}

/**
 * Read the geometry. Returns NULL if the Context has other positions than at the time of saving, or another structure;
 * sampling then continues from its present state. Throws an exception if the State is damaged.
 */
unique_ptr<KeptGeometry> TorsionMonteCarloIntegrator::readGeometry(const SerializationNode& state, int version) const
{
    const SerializationNode& node = state.getChildNode("Geometry");
    string data, others;
    if (!fromHexadecimal(node.getStringProperty("data"), data))
        fail("the State is damaged");
    stringstream stream(data);
    CheckpointReader reader(stream);
    if (reader.readVector<int>() != force->describeStructure())
        return NULL;
    unique_ptr<KeptGeometry> geometry(new KeptGeometry(reader));
    if (version > 3)
        checkTraits(state.getChildNode("Context"), *context, others);
    vector<Vec3> positions;
    context->getPositions(positions);
    const string written = node.getStringProperty("positions");
    if (fingerprintOf(positions) == written)
        force->checkCheckpoint(*context, *geometry);
    else {
        if (fingerprintOf(geometry->agreedPositions) == written && force->havePositionsOf(*context, *geometry))
            others.clear();
        geometry.reset();
    }
    if (!others.empty())
        warn("TorsionMonteCarloIntegrator: the Context differs from the time when the State was made; sampling "
             "continues "
             "from other " +
             others);
    return geometry;
}

/**
 * Read and check the whole State before using any of it.
 */
void TorsionMonteCarloIntegrator::deserializeParameters(const SerializationNode& node)
{
    ContextUse use(lock, ContextLock::User);
    requireBound();

    // Many integrators write no parameters to a State. Sampling may start from their States.

    auto& children = node.getChildren();
    if (!node.hasProperty("version") && children.empty() && node.getProperties().empty())
        return;
    bool isOurs = any_of(children.begin(), children.end(), [](const SerializationNode& child) {
        return child.getName() == "Limits";
    });
    if (!isOurs)
        fail("the integrator parameters of the State are those of another Integrator");
    int version = node.getIntProperty("version");
    checkVersion(version, NEWEST_STATE_VERSION, "the State of a TorsionMonteCarloIntegrator");
    if (version > 3)
        checkSeal(node);
    vector<pair<int, int>> pairs;
    vector<double> limits;
    for (auto& limit : node.getChildNode("Limits").getChildren()) {
        pairs.push_back(make_pair(limit.getIntProperty("p1"), limit.getIntProperty("p2")));
        limits.push_back(getNumber(limit, "overlap"));
    }
    if (version == 1) {
        force->setLimits(*context, pairs, limits);
        return;
    }
    RandomNumberGenerator restored(0);
    if (!restored.setState(node.getChildNode("Random").getStringProperty("state")))
        fail("the State is damaged");
    MoveList::Progress progress;
    const bool movesAreTheSame = moves->readProgress(node.getChildNode("Moves"), progress);
    vector<double> standIn, schedule;
    OuterStatistics restoredTests;
    if (version > 2) {
        standIn = NativeEnergy::readStandIn(node.getChildNode("StandIn"));
        schedule = NativeEnergy::readSchedule(node.getChildNode("StandIn"));
        restoredTests.read(node.getChildNode("OuterTests"));
    }
    const unique_ptr<KeptGeometry> geometry = readGeometry(node, version);
    if (geometry)
        force->loadCheckpoint(*geometry);
    else
        force->setLimits(*context, pairs, limits);
    *random = restored;
    if (movesAreTheSame)
        moves->setProgress(progress);
    if (version > 2) {
        native->setStandIn(standIn);
        native->setSchedule(schedule);
    }
    if (version > 2 && movesAreTheSame)
        *outerStatistics = restoredTests;
}

// ---- Sampling ----

double TorsionMonteCarloIntegrator::computeKineticEnergy()
{
    ContextUse use(lock, ContextLock::OpenMM);
    requireBound();
    const System& system = context->getSystem();
    vector<Vec3> velocities;
    context->getVelocities(velocities);
    double energy = 0;
    for (int i = 0; i < system.getNumParticles(); i++)
        energy += 0.5 * system.getParticleMass(i) * velocities[i].dot(velocities[i]);
    return energy;
}

/**
 * Run a trial of a move: hard spheres first, since they cost least, then the stages of U. Returns whether it was
 * accepted.
 */
static bool runTrial(MoveList::Entry& entry, TrialSession& trials, EnergyStages& stages, double temperature,
                     EnergyStages::Rule rule, RandomNumberGenerator& random)
{
    if (!entry.move->propose(trials, random)) {
        entry.counts.impossible++;
        return false;
    }
    if (!trials.test()) {
        trials.reject();
        entry.counts.clashed++;
        return false;
    }
    double logRatio = entry.move->computeLogRatio(trials);
    if (logRatio == -numeric_limits<double>::infinity()) {
        trials.reject();
        entry.counts.impossible++;
        return false;
    }
    if (entry.move->changesVolume()) {
        logRatio -= entry.move->computeWork(trials) / (BOLTZ * temperature);
        rule = EnergyStages::DecideBySum;
    }
    if (!stages.decide(trials, logRatio, temperature, rule, random)) {
        trials.reject();
        stages.reject();
        entry.counts.rejectedByEnergy++;
        return false;
    }
    trials.accept();
    stages.accept();
    entry.counts.accepted++;
    return true;
}

/**
 * Throw an exception if this System does not allow this mode, and warn if steps sample another distribution than the
 * user may expect.
 */
void TorsionMonteCarloIntegrator::checkBeforeSteps()
{
    const System& system = context->getSystem();
    const bool isHard = (native->getStericMode() == Hard);
    if (isHard)
        checkHardSpheres(system);
    if (moves->changeVolume())
        checkVolumeMoves(system, temperature);
    if (isHard && isBesideDynamics && !hasWarnedOfHardSpheres) {
        hasWarnedOfHardSpheres = true;
        warn("TorsionMonteCarloIntegrator: hard spheres beside dynamics: dynamics has no limits, so the two sample "
             "different distributions, and alternating them samples neither; call setStericMode(Soft), or Off");
    }
    if (!constraintsAreChecked && system.getNumConstraints() > 0) {
        vector<Vec3> positions;
        context->getPositions(positions);
        warnOfViolatedConstraints(system, positions);
    }
    constraintsAreChecked = true;
}

void TorsionMonteCarloIntegrator::step(int steps)
{
    {
        ContextUse use(lock, ContextLock::User);
        requireBound();
        moves->sumWeights();
        if (native->getStericMode() == Soft && ChainTreePlugin::hasSpheresOff(context->getIntegrator()))
            fail("its steric mode is Soft, but that of another integrator of the Context is Off, so that the "
                 "StericExclusionForce has no energy there; choose one mode for both");
        force->takeNoticeOfPositions(*context);
        checkBeforeSteps();
        if (isBesideDynamics) {
            HelperAdmission admission(*lock);
            force->getVelocityTurner().pauseDynamics(*context);
        }
    }
    SignalWatch signals((double)steps * trialsPerStep, secondsPerTrial);
    for (int i = 0; i < steps; i++) {
        int numTrials = 0;
        do {
            {
                // Other threads and handlers of signals may run between these parts.

                ContextUse use(lock, ContextLock::User);
                requireBound();
                if (numTrials == 0)
                    updateContextState();
                numTrials = runTrials(numTrials, signals);
            }
            if (!signals.handle())
                return;
        } while (numTrials < trialsPerStep);
    }
}

/**
 * Announces, until the end of the scope, that a step with trials begins.
 */
class StepBeginning {
public:
    StepBeginning(ContextLock& lock, VelocityTurner& velocities) : admission(lock), velocities(velocities)
    {
        velocities.announceStep(true);
    }
    ~StepBeginning()
    {
        velocities.announceStep(false);
    }
    StepBeginning(const StepBeginning&) = delete;
    StepBeginning& operator=(const StepBeginning&) = delete;

private:
    HelperAdmission admission;
    VelocityTurner& velocities;
};

/**
 * Let Forces change the Context, as at the beginning of each step.
 */
void TorsionMonteCarloIntegrator::updateContextState()
{
    const StepBeginning beginning(*lock, force->getVelocityTurner());
    context->updateContextState();
}

/**
 * Run trials until a step has ended, or until a signal asks for a pause.
 *
 * @param begin  the number of trials of the step that have been run
 * @return the new number of trials of the step that have been run
 */
int TorsionMonteCarloIntegrator::runTrials(int begin, SignalWatch& signals)
{
    const double weightSum = moves->sumWeights();
    const EnergyStages::Rule rule = nativeEnergies ? EnergyStages::DecideOneByOne : EnergyStages::DecideBySum;
    const StericMode mode = native->getStericMode();
    const TrialSession::Limits limits = mode == Hard  ? TrialSession::ApplyLimits
                                        : mode == Off ? TrialSession::ApplyTrialSpheres
                                                      : TrialSession::IgnoreLimits;
    native->judgeOuterTests();
    native->updatePlan();
    TrialSession trials(*force, *context, force->getTrialScene(), limits);
    if (mode != Hard)
        force->getLimitPolicy().restart();
    else if (initialClashPolicy == Refuse)
        force->getLimitPolicy().refuseToleratedClashes();
    native->begin(trials);
    stages->begin(trials);
    OuterTest test(trials, *native, *stages, *moves, *outerStatistics, *random, temperature, mode == Soft);
    int trial = begin;
    while (trial < trialsPerStep) {
        test.beginTrial();
        MoveList::Entry& move = moves->draw(weightSum, *random);
        const bool accepted = runTrial(move, trials, *stages, temperature, rule, *random);
        if (adaptMoveSizes)
            move.adaptSize(accepted);
        test.endTrial(accepted);
        trial++;
        if (signals.isUrgent())
            break;
    }
    test.end();
    if (trial == trialsPerStep) {
        context->setTime(context->getTime() + getStepSize());
        context->setStepCount(context->getStepCount() + 1);
    }
    trials.end();
    return trial;
}
