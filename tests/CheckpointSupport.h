#ifndef OPENMM_CHAINTREE_CHECKPOINTSUPPORT_H_
#define OPENMM_CHAINTREE_CHECKPOINTSUPPORT_H_

/**
 * Common code of the tests of checkpoints and States: a scene, a run on it, and writing and reading its state.
 */

#include "openmm/serialization/XmlSerializer.h"
#include "openmmchaintree/TorsionMonteCarloIntegrator.h"
#include "TestSupport.h"
#include <memory>

using namespace ChainTreePlugin;
using namespace OpenMM;
using namespace std;

/**
 * A chain that ends in a stiff clump of more beads than a leaf of the tree holds, a second chain whose first bead is
 * fixed, and a loose one. The first chain clashes with itself. There are 64 particles, a multiple of 32: else a GPU
 * platform pads them with others, and what their velocities happen to be is in its checkpoints too.
 */
class Scene : public BeadChain {
public:
    Scene() : BeadChain(9, 0.45, 0.3)
    {
        int first = system.getNumParticles();
        for (int i = 0; i < 43; i++) {
            system.addParticle(1);
            force->addParticle(0.2);
            positions.push_back(positions[8] + Vec3(0.1 * (i % 3), 0.1 * (i / 3 % 3), 0.1 * (i / 9)) + Vec3(0, 0, 0.6));
            force->addBond(i == 0 ? 8 : first, first + i);
            for (int j = 6; j < first + i; j++)
                if (j < 9 || j >= first)
                    force->addExclusion(j, first + i);
        }
        int fixed = addMolecule(7, 0.45, 2.5, Vec3(0, 0, 6));
        system.setParticleMass(fixed, 0);
        addMolecule(5, 0.45, 2.5, Vec3(0, 0, -6));
    }
    /**
     * The same positions after a turn about a skew axis.
     */
    vector<Vec3> getTurnedPositions() const
    {
        vector<Vec3> turned;
        for (const Vec3& position : positions)
            turned.push_back(rotate(position, Vec3(), Vec3(1, 2, 3), 2.0));
        return turned;
    }
};

/**
 * An integrator with all kinds of moves, in a Context.
 */
class Run {
public:
    Run(System& system, int seed, Platform& platform) : integrator(300)
    {
        integrator.setRandomNumberSeed(seed);
        integrator.setTrialsPerStep(50);
        integrator.addTorsionMove(3, 0.4);
        integrator.addTorsionMove(1, 0.3, {0, 2, 5, 7}, 3);
        integrator.addRigidBodyMove(1, 0.3, 0.5);
        context = make_unique<Context>(system, integrator, platform);
    }
    /**
     * The bytes of a checkpoint: the state of everything.
     */
    string createCheckpoint()
    {
        stringstream stream;
        context->createCheckpoint(stream);
        return stream.str();
    }
    void loadCheckpoint(const string& checkpoint)
    {
        stringstream stream(checkpoint);
        context->loadCheckpoint(stream);
    }
    int getNumToleratedClashes()
    {
        return integrator.getNumToleratedClashes(*context);
    }
    TorsionMonteCarloIntegrator integrator;
    unique_ptr<Context> context;
};

/**
 * The integrator's part of a checkpoint, without the size and checksum of OpenMM's part. What GPU platforms write there
 * tells of more than the simulation.
 */
inline string getOwnPart(const string& checkpoint)
{
    const size_t begin = checkpoint.find("ChainTMC"), size = 8 + 4;
    ASSERT(begin != string::npos);
    return checkpoint.substr(begin, size) + checkpoint.substr(begin + size + 16);
}

/** The version of our part of a State. */
static const string NEWEST_VERSION = "version=\"4\"";

inline string toXml(const State& state)
{
    stringstream stream;
    XmlSerializer::serialize<State>(&state, "State", stream);
    return stream.str();
}

inline State fromXml(const string& xml)
{
    stringstream stream(xml);
    unique_ptr<State> read(XmlSerializer::deserialize<State>(stream));
    return *read;
}

/**
 * As Simulation.saveState() and loadState() do it.
 */
inline State writeAndRead(const Context& context, bool enforcePeriodicBox = false)
{
    return fromXml(toXml(context.getState(
        State::Positions | State::Velocities | State::Parameters | State::IntegratorParameters, enforcePeriodicBox)));
}

/**
 * What copies of a Context were made from.
 */
class WrittenContext {
public:
    explicit WrittenContext(Context& context) :
        xml(toXml(context.getState(State::Positions | State::Parameters | State::IntegratorParameters)))
    {
        stringstream stream;
        context.createCheckpoint(stream);
        checkpoint = stream.str();
    }
    void loadCheckpoint(Context& context) const
    {
        stringstream stream(checkpoint);
        context.loadCheckpoint(stream);
    }
    string checkpoint, xml;
};

#endif /*OPENMM_CHAINTREE_CHECKPOINTSUPPORT_H_*/
