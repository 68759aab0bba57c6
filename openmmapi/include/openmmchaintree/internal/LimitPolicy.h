#ifndef OPENMM_CHAINTREE_LIMITPOLICY_H_
#define OPENMM_CHAINTREE_LIMITPOLICY_H_

#include "openmmchaintree/internal/CheckpointStream.h"
#include "openmmchaintree/internal/Scene.h"
#include <utility>
#include <vector>

namespace ChainTreePlugin {

/**
 * This class decides when the limits of pairs restart and when they may only grow. The Scene holds the limits.
 *
 * Limits restart when the user has set positions. They may only grow when the step of another Integrator has moved
 * particles, since sampling continues. OpenMM reports neither reliably, so this class infers it from the events below.
 */
class LimitPolicy {
public:
    LimitPolicy();
    /**
     * Set the scene that holds the limits. Call this once, before anything else.
     */
    void setScene(Scene& scene);
    /**
     * Let limits only grow when the step of an Integrator, or a Force at its beginning, has moved particles. Without
     * this call, steps restart limits, too.
     *
     * @param announced  whether all Integrators of the Context call updateContextState() when they begin a step. If
     *                   not, any unexplained change of positions may be a step.
     */
    void expectDynamics(bool announced);
    /**
     * Take notice that an Integrator begins a step.
     *
     * @param stepCount  the Context's step count
     */
    void stepBegins(long long stepCount);
    /**
     * Take notice that something other than this plugin has moved particles.
     */
    void particlesWereMoved();
    /**
     * Take notice that all changes of positions up to a step count have been seen.
     */
    void positionsWereSeen(long long stepCount);
    /**
     * Take notice that trials begin, so that no other Integrator is in a step.
     */
    void noStepIsUnderWay();
    /**
     * Take notice that radii, tolerances or the periodic box have changed. Limits may grow at the next trial.
     */
    void overlapsWereChanged();
    /**
     * Raise the limits of pairs that clash in the scene's state.
     */
    void update();
    /**
     * Forget all limits. The next trial raises them from the tolerances.
     */
    void restart();
    /**
     * Make these the only limits. They may still grow at the next trial.
     */
    void setLimits(const std::vector<std::pair<int, int>>& pairs, const std::vector<double>& limits);
    /**
     * Bring limits up to date, and throw an exception that names the first pair whose limit is not its tolerance, if
     * there is one.
     */
    void refuseToleratedClashes();
    /** The limits in a checkpoint. */
    class Kept {
    public:
        std::vector<std::pair<int, int>> pairs;
        std::vector<double> limits;
        bool isCurrent;
        long long stepBegun;
    };

    // Checkpoints hold the step at their end, so it is written and read apart.

    /**
     * Write the limits, and whether they are up to date.
     */
    void writeLimits(CheckpointWriter& writer) const;
    /**
     * Read the result of writeLimits().
     */
    static void readLimits(CheckpointReader& reader, Kept& kept);
    /**
     * Write which step may be under way.
     */
    void writeStep(CheckpointWriter& writer) const;
    /**
     * Read the result of writeStep().
     */
    static void readStep(CheckpointReader& reader, Kept& kept);
    /**
     * Use the limits of a checkpoint. Call this after the scene was given its state.
     *
     * @param hasPositions  whether that state has positions; without them there are no limits
     */
    void restore(const Kept& kept, bool hasPositions);

private:
    Scene* scene;
    /** Whether every pair that clashes in the scene's state has its limit. */
    bool isCurrent;
    bool dynamicsIsExpected, stepsAreAnnounced;
    /** The step count at which the last step began whose changes of positions may not all have been seen, or NO_STEP.
     *  Positions that differ without such a step were changed between steps: by the minimizer, of which OpenMM tells
     *  nothing on GPU platforms, or by Context::applyConstraints(). */
    long long stepBegun;
};

} // namespace ChainTreePlugin

#endif /*OPENMM_CHAINTREE_LIMITPOLICY_H_*/
