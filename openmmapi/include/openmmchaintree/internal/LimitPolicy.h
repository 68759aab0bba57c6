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
 * Limits restart when positions were set, since the user has chosen another start. They may only grow when the step of
 * another Integrator has moved particles, since the sampling continues. OpenMM reports neither with certainty, so this
 * class is told everything that helps to tell them apart.
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
     *                   not, whatever moves particles in silence may have been one of them.
     */
    void expectDynamics(bool announced);
    /**
     * Take notice that an Integrator begins a step.
     *
     * @param stepCount  the Context's step count
     */
    void stepBegins(long long stepCount);
    /**
     * Take notice that particles are seen where they were not put by this plugin.
     */
    void particlesWereMoved();
    /**
     * Take notice that all changes of positions up to a step count have been seen.
     */
    void positionsWereSeen(long long stepCount);
    /**
     * Take notice that nobody is in the midst of a step: trials begin.
     */
    void noStepIsUnderWay();
    /**
     * Take notice that radii or tolerances have changed. Limits may grow at the next trial.
     */
    void parametersWereChanged();
    /**
     * Make sure that every pair that clashes in the scene's state has its limit.
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
    /** What a checkpoint holds of limits. */
    class Kept {
    public:
        std::vector<std::pair<int, int>> pairs;
        std::vector<double> limits;
        bool isCurrent;
        long long stepBegun;
    };

    // Checkpoints hold what a step may still change after everything else, so it is written and read apart.

    /**
     * Write the limits, and whether they are up to date.
     */
    void writeLimits(CheckpointWriter& writer) const;
    /**
     * Read what writeLimits() wrote. This changes nothing.
     */
    static void readLimits(CheckpointReader& reader, Kept& kept);
    /**
     * Write which step may be under way.
     */
    void writeStep(CheckpointWriter& writer) const;
    /**
     * Read what writeStep() wrote. This changes nothing.
     */
    static void readStep(CheckpointReader& reader, Kept& kept);
    /**
     * Use what was read. Call this after the scene was given its state.
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
