#ifndef OPENMM_CHAINTREE_CONTEXTSNAPSHOT_H_
#define OPENMM_CHAINTREE_CONTEXTSNAPSHOT_H_

#include "openmm/Context.h"
#include "openmm/Vec3.h"
#include "openmmchaintree/internal/CheckpointStream.h"
#include <map>
#include <string>
#include <vector>

namespace ChainTreePlugin {

/**
 * The positions, velocities, box, parameters and time of a Context.
 */
class ContextSnapshot {
public:
    /**
     * Take a snapshot of a Context.
     *
     * @param context          the Context
     * @param positionsAreSet  whether the Context has positions. If not, restore() does not set positions.
     */
    ContextSnapshot(const OpenMM::Context& context, bool positionsAreSet);
    /**
     * Read the result of write().
     */
    explicit ContextSnapshot(CheckpointReader& reader);
    void write(CheckpointWriter& writer) const;
    /**
     * Read the positions again. Returns whether they have changed.
     */
    bool updatePositions(const OpenMM::Context& context);
    /**
     * Read the velocities again.
     */
    void updateVelocities(const OpenMM::Context& context);
    /**
     * Set all of them in a Context, except parameters that the Context does not have.
     */
    void restore(OpenMM::Context& context) const;

private:
    std::vector<OpenMM::Vec3> positions, velocities, box;
    std::map<std::string, double> parameters;
    double time;
    long long stepCount;
};

} // namespace ChainTreePlugin

#endif /*OPENMM_CHAINTREE_CONTEXTSNAPSHOT_H_*/
