#ifndef OPENMM_TORSIONMONTECARLOINTEGRATOR_H_
#define OPENMM_TORSIONMONTECARLOINTEGRATOR_H_

#include "internal/windowsExportChainTree.h"
#include "openmm/Context.h"
#include "openmm/Integrator.h"
#include "openmm/Kernel.h"
#include "openmm/State.h"
#include "TorsionDensity.h"
#include <iosfwd>
#include <memory>
#include <string>
#include <vector>

namespace OpenMM {
class SerializationNode;
}

namespace ChainTreePlugin {

class CheckpointReader;
class ContextLock;
class EnergyStages;
class KeptGeometry;
class MonteCarloMove;
class MoveList;
class NativeEnergy;
class OuterStatistics;
class RandomNumberGenerator;
class SignalWatch;
class StericExclusionForceImpl;
class TrialSession;

/**
 * This Integrator samples molecules by Monte Carlo moves of torsions, ball joints and whole molecules. Bond lengths are
 * fixed, and so are bond angles except at ball joints, unless there is an atom move; see addAtomMove(). It works with
 * the one StericExclusionForce of its System.
 *
 * The sampled distribution is uniform in torsion angles, in the rotations of ball joints and in the placement of rigid
 * bodies, weighted by
 *
 *     pi(x) ~ exp(-U(x)/kT)
 *
 * where U is the energy of the integration force groups without the StericExclusionForce, even if it is in one of these
 * groups. This is the steric mode Off: the spheres of that force have no effect. Automatic, the default, means Off if a
 * NonbondedForce or CustomNonbondedForce of these groups holds all particles that have a radius. Otherwise it means
 * Hard:
 *
 *     pi(x) ~ exp(-U(x)/kT) * 1[no pair of particles overlaps beyond its limit]
 *
 * If no other force can contribute energy, sampling is athermal: every trial without a clash is accepted. A
 * CMMotionRemover or AndersenThermostat has no energy. The Forces and their groups are read when the Context is
 * created; later changes of the System have no effect until it is reinitialized.
 *
 * <b>Soft spheres.</b> After setStericMode(Soft) there are no limits, and no trial is rejected by a clash. Instead, the
 * energy E of the StericExclusionForce is part of the sampled energy, for any force group:
 *
 *     pi(x) ~ exp(-(U(x) + E(x))/kT)
 *
 * Dynamics samples this ensemble if the force takes part in it. To alternate Monte Carlo and dynamics in a
 * CompoundIntegrator, use Soft or Off: with Hard they would sample different distributions, and their alternation
 * neither. (The dynamics must be at constant temperature, with Soft the group of the force must be among its
 * integration force groups, and trials keep the bond lengths and angles at which dynamics stopped.)
 *
 * <b>Early rejection.</b> With Off, a trial is still rejected before its energy is computed if it brings two particles
 * so close that their Lennard-Jones repulsion, less the greatest Coulomb attraction of such a pair, exceeds 60 kT (at
 * 500 K, or at the temperature if that is higher). This needs a NonbondedForce, and no other energy of pairs or foreign
 * Force. Such trials count as clashed. A charge without Lennard-Jones, such as the hydrogen of a hydroxyl group in
 * AMBER, has an energy without minimum near an opposite charge; it is kept 0.001 nm away from the core of any other
 * particle, whose radius is about 0.1 nm. If a pair is that close when a step begins, the step has no early rejection.
 *
 * <b>Steps and trials.</b> A step consists of many trials, 100 by default; see setTrialsPerStep(). Each trial draws one
 * of the moves by its weight and proposes it. If a pair then overlaps beyond its limit, the trial is rejected, usually
 * within microseconds; otherwise the change of U decides. A trial whose energy is not a number is rejected, and counts
 * as rejected by energy. A step takes 0 ps, since Monte Carlo has no time. OpenMM's reporters therefore show steps,
 * progress and remaining time as usual, the temperature of the heat bath, and a speed of 0 ns/day. setStepSize() gives
 * a step a length without changing the sampling: after setStepSize(1000), in ps, the speed is in steps per day.
 *
 * <b>Energies.</b> Each Force of the integration force groups is one of three kinds. getEnergyPlan() tells which, and
 * why.
 *
 * - Constant: no move can change it, such as bonds and angles whose particles keep their distances. It costs no time.
 * - Native: this library evaluates the terms that a trial changes, in microseconds. Native are NonbondedForce (of Ewald
 *   summation and PME the direct space; OpenMM evaluates the reciprocal space like a foreign Force), HarmonicBondForce,
 *   HarmonicAngleForce, PeriodicTorsionForce, RBTorsionForce, CMAPTorsionForce, CustomBondForce, CustomAngleForce,
 *   CustomTorsionForce, CustomCompoundBondForce, CustomExternalForce, CustomNonbondedForce, and generalized Born. A
 *   CustomGBForce of another form is evaluated as a whole, in milliseconds: in each trial that passed the earlier
 *   stages, or once in many trials like a foreign Force. Forces with periodic boundary conditions are native if the
 *   StericExclusionForce has them, too. In such a box, pairs without images are foreign.
 * - Foreign: all other Forces. OpenMM evaluates each of them alone, without the rest of its force group, once in many
 *   trials (see below), or in each trial that passed the earlier stages if trials change it too much. GPU platforms
 *   evaluate force groups as a whole; there, foreign Forces that share a group with native ones are copied to an inner
 *   Context. Forces of other plugins cannot be copied, so put them in a group without native ones.
 *
 * A trial passes through stages, cheapest first: bonded terms, near pairs, soft spheres, the other pairs, computed
 * values, foreign Forces. Each stage lets it pass with probability min(1, exp(-dU/kT)), where dU is the change of that
 * stage's part of U, and the trial is rejected at the first stage that it fails. This samples exp(-U/kT) exactly
 * (delayed acceptance; Christen and Fox, J. Comput. Graph. Stat. 14, 795 (2005)). getStageStatistics() tells at which
 * stage trials were rejected. At a temperature of 0, and after setNativeEnergies(false), a trial is accepted with
 * probability min(1, exp(-(U' - U)/kT)).
 *
 * OpenMM's own energy is compared at the first step, after changes of parameters, and every million trials. If a native
 * Force has another energy than OpenMM computes, step() throws an exception that names it.
 *
 * The positions are copied to the Context once per step; with foreign Forces, also for each trial or outer test that
 * needs them.
 *
 * <b>Outer tests.</b> Trials can omit an expensive part of U. They are then decided by the rest, U1. After m of them,
 * an outer test keeps all trials accepted since the last test with probability min(1, exp(-((U' - U1') - (U -
 * U1))/kT)), where U and U1 are the energies at the last test, and otherwise restores the state at the last test. This
 * samples exp(-U/kT) exactly, however large the omitted part is (nested Monte Carlo). At a temperature of 0 the trials
 * are kept unless U has increased. Outer tests decide
 *
 * - foreign Forces, which OpenMM then evaluates once per test and once per step instead of once per trial. By default
 *   the first tests find out which Forces allow this, and a suitable m; see setTrialsPerOuterTest();
 * - the error of a stand-in. In generalized Born solvation every pair of particles depends on all others. It is native,
 *   but trials see an approximation, together with Coulomb energies, that depends on few particles; see
 *   setStandInCutoffs() and renewStandIns().
 *
 * Only getOuterStatistics() counts the trials that outer tests undid. If most are undone, reduce m or the sizes of
 * moves. A warning says so if 100 tests kept few trials.
 *
 * <b>Moves.</b> Add at least one by addTorsionMove(), addRigidBodyMove(), addClosedMove(), addLocalMove() or another
 * method whose name begins so.
 *
 * @code
 * TorsionMonteCarloIntegrator integrator(300);
 * integrator.addTorsionMove(1, 0.2);            // one torsion, by up to 0.2 radians
 * integrator.addRigidBodyMove(0.1, 0.05, 0.1);  // one molecule, by up to 0.05 nm and 0.1 radians
 * Context context(system, integrator);
 * context.setPositions(positions);
 * integrator.step(1000);                        // 100,000 trials
 * @endcode
 *
 * <b>Limits.</b> The limit of a pair is its tolerance, unless the pair clashes when sampling starts; see
 * StericExclusionForce, also for what restarts limits. setInitialClashPolicy() chooses whether such clashes are
 * tolerated, which is the default, or refused. Minimizing the energy counts as setting positions. (On GPU platforms
 * this library notices it only if it moved a particle and, after steps of another Integrator, evaluated the
 * StericExclusionForce. If in doubt, call StericExclusionForce::restartLimits().)
 *
 * <b>Velocities.</b> At the end of a step, the velocities of each rigid link are rotated as the step rotated the link.
 * This keeps the kinetic energy, and constraints within links and along the axes of torsions, so that alternating
 * dynamics and Monte Carlo sample one temperature. If the System has a CMMotionRemover, its momentum is kept as well. A
 * constraint across a ball joint, or across the axis of a torsion, such as the constraint of an angle, is an error
 * beside dynamics. Velocities that are all 0 remain 0, at no cost.
 *
 * Most integrators keep velocities of half a step before the positions, which depend on the forces there. So when
 * another Integrator of a CompoundIntegrator resumes, velocities are also rotated from the direction of the
 * accelerations at its last step to their present direction, keeping kinetic energy and constraints. That evaluates
 * forces twice each time another Integrator resumes. An Integrator that does not call updateContextState() resumes
 * without this rotation.
 *
 * <b>Errors.</b> Creating a Context throws an exception if its System has no StericExclusionForce or more than one, a
 * barostat while spheres are Hard, or a constraint between particles that a torsion or ball joint moves relative to
 * each other, or if a move names something that does not exist. A step throws an exception if no move can be drawn, if
 * U at the present positions or these are not finite numbers, if OpenMM has another energy for a native Force, or if
 * another Force throws one. The Context then holds the last accepted state (with outer tests, the state after the last
 * test), and the statistics count the trials up to there, but not the step.
 *
 * <b>Threads.</b> One thread at a time uses this plugin's data of a Context; calls of this plugin in other threads
 * wait. Meanwhile, calls of OpenMM that would evaluate or change the Context throw an exception: getState() with
 * energies, setPositions() and loadCheckpoint(), for example. So does a Force that calls this integrator or the
 * StericExclusionForce about its own Context while it is evaluated.
 *
 * <b>Signals in Python.</b> Ctrl-C, and any signal that has a handler in Python, interrupts a step() of the main thread
 * within a second. The handler runs between two steps, where it may save a checkpoint, and sampling continues if it
 * returns. In a step longer than a second it runs during the step: an unfinished outer test is made at once, so that
 * sampling stays exact, and the step continues if the handler returns. If it raises an exception, as the handler of
 * Ctrl-C does, the step is not counted, and the caller of step() gets the exception.
 *
 * <b>Checkpoints and States.</b> With the same random number seed, the same program samples the same trajectory, bit
 * for bit, also if it is interrupted between two steps and resumed from a checkpoint, or from a State with positions
 * and integrator parameters as app.Simulation saves it in Python. Both hold the random number generator, the limits,
 * the statistics of moves and outer tests, the scales of moves, the constants of a stand-in, and the torsion angles and
 * placements from which positions are computed. Making one recomputes the sums of native energies, so the energies of a
 * run with checkpoints can differ in the last bits from a run without. Neither holds a trial that the user has proposed
 * through StericExclusionForce, the counts of getStageStatistics(), or the settings of this class (temperature, steric
 * mode, native energies, trials per step, moves, whether their sizes adapt): set these to the same values to get the
 * same bits.
 *
 * Loading a checkpoint is strict. It throws an exception if the checkpoint is of another structure or if its moves
 * differ from the moves of this integrator: their number, kinds, parameters, weights and order must be equal. The
 * exception names the first move that differs. (To continue with other moves, load the checkpoint first and change the
 * moves then.) It also throws if the checksum of OpenMM's part or of this integrator's part differs. (A C++ program
 * that writes a checkpoint to a file stream instead of a stringstream gets a checksum of this integrator's part only.)
 * Checkpoints of version 4 and before have no checksum, but links and positions must fit each other. OpenMM restores
 * positions, velocities, parameters and time before it calls the Integrator, so after the exception the Context has
 * these from the checkpoint; limits restart from these positions, and everything else is as before.
 *
 * Loading a State is not strict. Its random number generator and limits are always used, the statistics and scales only
 * if the moves are the same. If the Context has another structure, or other bits of the positions than at the time of
 * saving (for example because the State was made with enforcePeriodicBox, or holds no positions), sampling continues
 * from the positions of the Context, within rounding. A warning tells if positions, velocities or parameters differ
 * from the time of saving. A damaged State is refused, and no setting of this integrator changes: damaged means that a
 * checksum of these parameters, the time or the box differs, that a single number of all positions or velocities
 * differs, or that a link has another shape while some particles are where they were. States of version 1 hold only
 * limits, States of version 2 nothing about outer tests, States of version 3 no checksums.
 *
 * <b>A refused reinitialize().</b> Context::reinitialize() throws an exception if a Force or this integrator does not
 * accept the changed System, and leaves an incomplete Context. The integrator then keeps the Context's positions,
 * velocities, box, parameters, time and state of sampling. Correct what the exception named and call
 * reinitialize(true): sampling continues, bit for bit, as if there had been no exception. Positions and velocities that
 * are set in between replace the saved ones, and such positions restart limits. createCheckpoint() writes the saved
 * state. Every other call that needs the state of sampling throws an exception until then. Such a Context reports the
 * saved positions if this integrator threw the exception, and undefined ones otherwise.
 */
class OPENMM_EXPORT_CHAINTREE TorsionMonteCarloIntegrator : public OpenMM::Integrator {
public:
    /**
     * How pairs that clash when sampling starts are treated.
     */
    enum InitialClashPolicy {
        /**
         * Each of them gets its initial overlap as its limit.
         */
        Tolerate = 0,
        /**
         * step() throws an exception that names the first of them.
         */
        Refuse = 1
    };
    /**
     * How the StericExclusionForce takes part in sampling.
     */
    enum StericMode {
        /**
         * A trial is rejected if a pair overlaps beyond its limit.
         */
        Hard = 0,
        /**
         * The energy of the force is part of the sampled energy, and there are no limits.
         */
        Soft = 1,
        /**
         * Spheres have no effect, and the force has no energy in the Context.
         */
        Off = 2,
        /**
         * Off if a NonbondedForce or CustomNonbondedForce of the integration force groups holds all particles of the
         * force that have a radius, else Hard.
         */
        Automatic = 3
    };
    /**
     * The kinds of moves.
     */
    enum MoveType {
        /**
         * A move added by addTorsionMove().
         */
        TorsionMove = 0,
        /**
         * A move added by addRigidBodyMove().
         */
        RigidBodyMove = 1,
        /**
         * A move added by addClosedMove().
         */
        ClosedMove = 2,
        /**
         * A move added by addLocalMove().
         */
        LocalMove = 3,
        /**
         * A move added by addDrawnMove().
         */
        DrawnMove = 4,
        /**
         * A move added by addPivotMove().
         */
        PivotMove = 5,
        /**
         * A move added by addCrankshaftMove().
         */
        CrankshaftMove = 6,
        /**
         * A move added by addVolumeMove().
         */
        VolumeMove = 7,
        /**
         * A move added by addGroupMove().
         */
        GroupMove = 8,
        /**
         * A move added by addAtomMove().
         */
        AtomMove = 9
    };
    /**
     * Who evaluates the energy of a Force for a trial.
     */
    enum EnergyKind {
        /**
         * No code: it is not part of U.
         */
        NotSampled = 0,
        /**
         * This library, once. No move can change it.
         */
        Constant = 1,
        /**
         * This library, which mostly computes only the terms that the trial changes.
         */
        Native = 2,
        /**
         * OpenMM.
         */
        Foreign = 3
    };
    /**
     * An entry of getEnergyPlan().
     */
    struct PlannedEnergy {
        /** The index of the Force in the System. */
        int force;
        /** The name of the Force. */
        std::string name;
        /** Who evaluates its energy for a trial. */
        EnergyKind kind;
        /** How often, and why, in a clause. */
        std::string reason;
    };
    /**
     * An entry of getStageStatistics().
     */
    struct StageStatistics {
        /** The name of the part, for people to read. */
        std::string stage;
        /** The number of trials that reached this part, so that its change was computed. */
        long long computed;
        /** How many of them it rejected. The others reached the next part, or were accepted. */
        long long refused;
    };
    /**
     * Create a TorsionMonteCarloIntegrator without moves.
     *
     * @param temperature  the temperature of the heat bath, in Kelvin
     */
    explicit TorsionMonteCarloIntegrator(double temperature);
    ~TorsionMonteCarloIntegrator();
    /**
     * Get the temperature of the heat bath, in Kelvin.
     */
    double getTemperature() const;
    /**
     * Set the temperature of the heat bath. It has no influence on athermal sampling.
     *
     * @param temperature  the temperature, at least 0, in Kelvin
     */
    void setTemperature(double temperature);
    /**
     * Get the random number seed. See setRandomNumberSeed() for details.
     */
    int getRandomNumberSeed() const;
    /**
     * Set the random number seed. Two Contexts created with the same seed and the same program sample the same
     * trajectory, bit for bit. If the seed is 0, which is the default, every Context gets a different one. Setting the
     * seed has no effect on an existing Context until it is reinitialized.
     *
     * @param seed  the random number seed
     */
    void setRandomNumberSeed(int seed);
    /**
     * Get the number of trials in one step. The default is 100.
     */
    int getTrialsPerStep() const;
    /**
     * Set the number of trials in one step.
     *
     * @param trials  the number of trials, at least 1
     */
    void setTrialsPerStep(int trials);
    /**
     * Get how pairs that clash when sampling starts are treated. The default is Tolerate.
     */
    InitialClashPolicy getInitialClashPolicy() const;
    /**
     * Set how pairs that clash when sampling starts are treated.
     *
     * @param policy  Tolerate or Refuse
     */
    void setInitialClashPolicy(InitialClashPolicy policy);
    /**
     * Get how the StericExclusionForce takes part in sampling. The default is Automatic.
     */
    StericMode getStericMode() const;
    /**
     * Set how the StericExclusionForce takes part in sampling. With Soft its energy is added to U, whether or not its
     * force group is one of the integration force groups. With Soft and Off no limit applies, and the initial clash
     * policy is not used. With Off the force has neither energy nor forces in the Context, also for other
     * integrators of a CompoundIntegrator.
     *
     * The mode may change between two steps. Hard steps after steps of other modes restart limits from the present
     * clashes.
     *
     * @param mode  Automatic, Off, Hard or Soft
     */
    void setStericMode(StericMode mode);
    /**
     * Get how the StericExclusionForce takes part in sampling in this integrator's Context: Off or Hard if the steric
     * mode is Automatic. getEnergyPlan() says why.
     *
     * @param context  the Context of this integrator
     */
    StericMode getStericModeInContext(OpenMM::Context& context) const;
    /**
     * Get whether the steric mode is Off, or is Automatic and means Off in this integrator's Context.
     */
    bool hasSpheresOff() const;
    /**
     * Get whether there is an atom move, with any weight. In a Context that is made then, particles can be displaced
     * within their links.
     */
    bool displacesParticles() const;
    /**
     * Get the share of atom moves among all trials, by the weights of the moves. It is 0 if no move can be drawn.
     */
    double getAtomMoveShare() const;
    /**
     * Get whether the energies of native Forces are evaluated by this library. The default is true.
     */
    bool getNativeEnergies() const;
    /**
     * Set whether the energies of native Forces are evaluated by this library. If not, OpenMM evaluates U for each
     * trial without a clash, and decides it by the sum of all Forces; the same distribution is sampled. This may change
     * between two steps.
     *
     * @param native  whether the library evaluates native Forces
     */
    void setNativeEnergies(bool native);
    /**
     * Get the number of trials to an outer test. See setTrialsPerOuterTest() for details.
     */
    int getTrialsPerOuterTest() const;
    /**
     * Set the number of trials to an outer test, which keeps all trials accepted since the last test or undoes them. A
     * step always ends with a test, so for 400 trials set 400 or a multiple of it by setTrialsPerStep().
     *
     * With 0, which is the default, a stand-in is tested after 400 trials, where five trials of atom moves count as
     * one: they change U less. So the number grows with the share of atom moves, up to 2,000. CustomGBForces that are
     * evaluated as a whole decide each trial. The first tests measure how much trials change the foreign Forces. They
     * come after 12 trials at first, then after up to 400 or the trials of a step, while more than half of the tests
     * are expected to keep their trials (a standard deviation of the differences below 1.35 kT). Forces that change
     * more than that in 12 trials decide each trial from then on. The choice is fixed after some thousand trials; take
     * no statistics before. Checkpoints and States hold it, and renewStandIns() repeats it.
     *
     * With a number of at least 1, all of these are tested after that number of trials. Without any of them there is no
     * outer test. The number may change between two steps.
     *
     * @param trials  the number of trials, or 0
     */
    void setTrialsPerOuterTest(int trials);
    /**
     * Get the results of outer tests, since the integrator was created or resetMoveStatistics() was called. The
     * difference of a test is the change of U - U1, the part of U that trials omit; tests without an accepted trial
     * have none. It should be a few kJ/mol at most. If its standard deviation is s, in units of kT, about
     * erfc(s / sqrt(8)) of the tests keep their trials.
     *
     * @param[out] attempted          the number of tests
     * @param[out] accepted           how many of them kept their trials
     * @param[out] trialsTakenBack    the number of trials that the others undid. No other statistics count them.
     * @param[out] meanDifference     the mean of the differences, in kJ/mol; 0 if there are none
     * @param[out] standardDeviation  their standard deviation, in kJ/mol; 0 if there are fewer than two
     */
    void getOuterStatistics(long long& attempted, long long& accepted, long long& trialsTakenBack,
                            double& meanDifference, double& standardDeviation) const;
    /**
     * Recompute the constants of the stand-in at the present positions. The first step of a Context does so; after it
     * they do not change, which makes sampling exact, and checkpoints and States hold them. Call this in equilibration,
     * or if getOuterStatistics() shows that few tests keep their trials because the conformation is far from the one
     * of the constants. The next tests also choose again which foreign Forces outer tests decide, and after how many
     * trials. Nothing happens if there is neither a stand-in nor a foreign Force.
     *
     * @param context  the Context that this integrator is bound to
     */
    void renewStandIns(OpenMM::Context& context);
    /**
     * Get the cutoffs of a stand-in. See setStandInCutoffs() for details.
     *
     * @param[out] bornCutoff  the largest distance of particles in a Born sum, in nm
     * @param[out] pairCutoff  the largest distance of particles that interact, in nm
     */
    void getStandInCutoffs(double& bornCutoff, double& pairCutoff) const;
    /**
     * Set the cutoffs of a stand-in. They do not influence the sampled distribution, only the speed: larger ones make a
     * trial cost more, and with smaller ones fewer outer tests keep their trials. The defaults are 0.55 and 0.8 nm.
     * Another bornCutoff recomputes the stand-in, as renewStandIns() does.
     *
     * @param bornCutoff  the largest distance of particles in a Born sum, in nm; those beyond it are replaced by a
     *                    constant of each particle
     * @param pairCutoff  the largest distance of particles that interact, in nm
     */
    void setStandInCutoffs(double bornCutoff, double pairCutoff);
    /**
     * Get the width of the grid of Born radii of a stand-in. See setStandInGridWidth() for details.
     */
    double getStandInGridWidth() const;
    /**
     * Set the width of the grid of Born radii of a stand-in: in its pair energies their logarithms are rounded to
     * multiples of it, or of up to four times as much where the charge is small. It does not influence the sampled
     * distribution, only the speed. The default is 0.08.
     *
     * @param width  the width, above 0
     */
    void setStandInGridWidth(double width);
    /**
     * Get who evaluates the energy of each Force for a trial, and why, by the present choice of integration force
     * groups, native energies and steric mode.
     *
     * @param context  the Context that this integrator is bound to
     * @return one entry for each Force of the System
     */
    std::vector<PlannedEnergy> getEnergyPlan(OpenMM::Context& context) const;
    /**
     * Get U of the present positions as sampling uses it, with the energy of the StericExclusionForce if spheres are
     * soft. After steps of this integrator, native energies are the sums that trials have updated, not recomputed.
     *
     * @param context  the Context that this integrator is bound to
     * @return the energy, in kJ/mol
     */
    double getPotentialEnergy(OpenMM::Context& context) const;
    /**
     * Get how many trials each part of U has rejected, since the Context was created or resetMoveStatistics() was
     * called. Parts that decided no trial have counts of 0.
     */
    std::vector<StageStatistics> getStageStatistics() const;
    /**
     * Get the number of pairs whose limit is not their tolerance. The same as
     * StericExclusionForce::getNumToleratedClashes().
     *
     * @param context  the Context that this integrator is bound to
     */
    int getNumToleratedClashes(OpenMM::Context& context) const;
    /**
     * Add a move that turns torsions: a number of different torsions of a list, each by an angle drawn uniformly from
     * -maxAngle to maxAngle.
     *
     * @param weight    how often this move is drawn, relative to the weights of the others, at least 0
     * @param maxAngle  the largest angle, from 0 to pi, in radians; with pi the new angle is independent of the old one
     * @param torsions  the indices of the torsions of the StericExclusionForce to choose from; if empty, all of them.
     *                  In Python None means all of them, and an empty list is an error.
     * @param count     the number of torsions that one trial turns
     * @return the index of the move that was added
     */
    int addTorsionMove(double weight, double maxAngle, const std::vector<int>& torsions = std::vector<int>(),
                       int count = 1);
    /**
     * Add a move that shifts and turns a whole molecule as a rigid body. The translation is drawn uniformly from a ball
     * of radius maxTranslation. The rotation is about the centroid of the molecule's particles, with an axis drawn
     * uniformly from all directions and an angle drawn uniformly from -maxAngle to maxAngle.
     *
     * @param weight          how often this move is drawn, relative to the weights of the others, at least 0
     * @param maxTranslation  the largest translation, at least 0, in nm
     * @param maxAngle        the largest angle, from 0 to pi, in radians
     * @param molecules       the molecules to choose from, each named by any one of its particles; if empty, all
     *                        molecules without fixed particles. In Python None means all of them, and an empty list is
     *                        an error.
     * @return the index of the move that was added
     */
    int addRigidBodyMove(double weight, double maxTranslation, double maxAngle,
                         const std::vector<int>& molecules = std::vector<int>());
    /**
     * Add a move that turns consecutive torsions so that the rest of the chain stays in place: an exact concerted
     * rotation. In a folded molecule it changes a piece of the backbone without moving the rest.
     *
     * A <i>window</i> is a row of eight torsions of the list (nine or seven where eight cannot be) along a chain, each
     * of which moves the next. Six of them, the pivots, close it: three pairs of neighbours, the two bonds of a pair
     * sharing a particle, such as phi and psi of a residue. The others, the drivers, are drawn: the first and the last
     * where this can be. The part of the chain between two torsions of a window, with its branches, moves as a rigid
     * body of any shape. Torsions of the chain that are not in the list do not turn.
     *
     * A trial draws a window, adds angles drawn uniformly from -maxAngle to maxAngle to its drivers, and turns the
     * pivots so that the window closes: mostly to the solution that Newton's method finds from the present angles, and
     * in a share `hop` of the trials to one of all solutions, near ones preferred. The ratio holds the Jacobians of
     * both states and the weights of the solutions, and a trial that the same method would not reverse is rejected, so
     * that without energy and spheres torsions are sampled uniformly. Trials that do not close count as attempted only.
     *
     * Torsions in rings of closures (StericExclusionForce::addClosure()) turn by this move only. A window keeps the two
     * particles of a closure in place, or moves them as one piece. In a ring, windows also lead over the closure and
     * over the link to which the ring is attached: then the rest of the ring moves as one piece, with its branches.
     *
     * This move never moves the part of a chain behind its last window, so add a move by addTorsionMove(), too.
     *
     * See Dodd, Boone and Theodorou, Mol. Phys. 78, 961 (1993); Coutsias, Seok, Jacobson and Dill, J. Comput. Chem. 25,
     * 510 (2004); Hoffmann and Knapp, Eur. Biophys. J. 24, 387 (1996).
     *
     * It is an error, found when the Context is made, if the torsions have no window.
     *
     * @param weight    how often this move is drawn, relative to the weights of the others, at least 0
     * @param maxAngle  the largest angle of a driver, from 0 to pi, in radians
     * @param torsions  the indices of the torsions of the StericExclusionForce that windows may turn; if empty, the
     *                  torsions of all backbones, as in addLocalMove(), and of rings of closures. In Python None means
     *                  these, and an empty list is an error.
     * @param hop       the share of trials that choose among all solutions, from 0 to 1
     * @return the index of the move that was added
     */
    int addClosedMove(double weight, double maxAngle, const std::vector<int>& torsions = std::vector<int>(),
                      double hop = 0.2);
    /**
     * Add a move that turns a window of consecutive torsions by small angles at once, so that the chain behind the
     * window moves little: biased Gaussian steps (Favrin, Irback and Sjunnesson, J. Chem. Phys. 114, 8154 (2001)).
     *
     * The three ends of a window are the particles of the axis of its last torsion and the particle that this torsion
     * has next to it, on the side that it turns. With their positions r_k (nm), and G_ij = sum_k dr_k/dphi_i .
     * dr_k/dphi_j (nm^2), the changes d of the torsions are drawn from a normal distribution with a density of
     * sqrt(det A) exp(-d A d / 2), A = (I + stiffness*G)/sigma^2. So torsions whose effects on the ends cancel turn by
     * about sigma, and changes that shift the ends are rare. The acceptance probability includes the ratio of the
     * densities of the reverse step and of the step, sqrt(det A'/det A) exp(-d (A' - A) d / 2), so sampling is exact.
     *
     * All windows are equally likely: the rows of `window` torsions of the list that follow each other from the root
     * of a molecule outwards, and the shorter rows at the two ends of a chain, so that each torsion is in equally many
     * windows. Torsions that are not in the list do not turn, and do not end a window.
     *
     * @param weight     how often this move is drawn, relative to the weights of the others, at least 0
     * @param sigma      the standard deviation of the change of a torsion that shifts no end, above 0 and at most pi,
     *                   in radians
     * @param stiffness  how rare it is that the ends are shifted, at least 0, in nm^-2: the standard deviation of a
     *                   change that shifts the ends by r for each radian is sigma/sqrt(1 + stiffness*r^2)
     * @param torsions   the indices of the torsions of the StericExclusionForce that windows consist of; if empty, the
     *                   torsions of all backbones: of the path from the root of a molecule along which torsions move
     *                   most particles, and of branches with at least 8 torsions. In Python None means these, and an
     *                   empty list is an error.
     * @param window     the number of torsions of a window, from 1 to 32
     * @return the index of the move that was added
     */
    int addLocalMove(double weight, double sigma, double stiffness,
                     const std::vector<int>& torsions = std::vector<int>(), int window = 8);
    /**
     * Add a move that draws new values of torsions from a density, independent of the old ones. A trial chooses one of
     * some sets of torsions with equal probability, such as all torsions of a side chain or phi and psi of a residue.
     * With p the density of the set, q its present values and q' the drawn ones, it is accepted with
     * min(1, exp(-(U' - U)/kT) p(q)/p(q')), so that the sampled distribution does not depend on the density.
     *
     * A good density is close to the sampled one, such as the density of rotamers for side chains, or of coil residues
     * for phi and psi. In Python rotamerDensities() and ramachandranDensities() find sets and densities in a Topology.
     *
     * The value of a torsion is defined in StericExclusionForce::addTorsion(). If a torsion has none, because three of
     * its particles are collinear, the trial that would draw it is an error.
     *
     * @param weight     how often this move is drawn, relative to the weights of the others, at least 0
     * @param torsions   the sets, each of different torsions of the StericExclusionForce, by their indices. Different
     *                   sets can have torsions in common.
     * @param densities  the density of each set, which is of as many torsions, in their order; or one density for all
     * @return the index of the move that was added
     */
    int addDrawnMove(double weight, const std::vector<std::vector<int>>& torsions,
                     const std::vector<TorsionDensity>& densities);
    /**
     * Add a move that turns one ball joint, drawn uniformly from a list: everything behind the joint rotates about its
     * particle. For chains of beads this is the pivot algorithm. The axis is drawn uniformly from all directions and
     * the angle uniformly from -maxAngle to maxAngle. With a maxAngle of pi all rotations are equally likely, so that
     * the new directions do not depend on the old ones. (An angle drawn uniformly from -pi to pi would prefer small
     * rotations.) Either way a rotation and its reverse are equally likely.
     *
     * Large rotations change the shape of a loose chain in few trials, since many of them are free of clashes (Lal,
     * Mol. Phys. 17, 57 (1969); Madras and Sokal, J. Stat. Phys. 50, 109 (1988)). A compact chain needs small ones.
     * Most chains do best with a move of each kind.
     *
     * @param weight      how often this move is drawn, relative to the weights of the others, at least 0
     * @param maxAngle    the largest angle, from 0 to pi, in radians; with pi the new direction is independent of the
     * old one
     * @param ballJoints  the indices of the ball joints of the StericExclusionForce to choose from; if empty, all of
     *                    them. In Python None means all of them, and an empty list is an error.
     * @return the index of the move that was added
     */
    int addPivotMove(double weight, double maxAngle, const std::vector<int>& ballJoints = std::vector<int>());
    /**
     * Add a move that turns a piece of a chain about the line between its ends, which stay in place with the rest of
     * the chain. For chains of beads this is the crankshaft move: unlike a pivot, it moves few beads.
     *
     * The ends are the particles of two ball joints of the list, the one behind the other along a chain. The trial
     * draws the last one uniformly from all that have two more of the list before them, then the number of bonds
     * between the two uniformly, from 2 to `window` as far as the chain reaches, and an angle uniformly from -maxAngle
     * to maxAngle. The two ball joints turn by opposite angles about the line. A trial and its reverse are equally
     * likely.
     *
     * This move keeps the ends of a chain and the first bond behind the last ball joint, so add a move by
     * addPivotMove(), too.
     *
     * It is an error, found when the Context is made, if no three ball joints of the list follow each other.
     *
     * @param weight      how often this move is drawn, relative to the weights of the others, at least 0
     * @param maxAngle    the largest angle, from 0 to pi, in radians
     * @param ballJoints  the indices of the ball joints of the StericExclusionForce to choose from; if empty, all of
     *                    them. In Python None means all of them, and an empty list is an error.
     * @param window      the largest number of ball joints from one end to the other, at least 2
     * @return the index of the move that was added
     */
    int addCrankshaftMove(double weight, double maxAngle, const std::vector<int>& ballJoints = std::vector<int>(),
                          int window = 8);
    /**
     * Add a move that changes the volume V of the periodic box at constant pressure P. With it, steps sample
     *
     *     pi(x, V) ~ exp(-(U(x, V) + P V)/kT),
     *
     * with the spheres' part as in the class description. All box vectors are multiplied by one factor, so the box
     * keeps its shape; and so are the centroids (mean positions) of all molecules, which move as rigid bodies, as
     * MonteCarloBarostat does it. A molecule is one of the StericExclusionForce, a single particle included.
     *
     * A trial changes ln V by a uniform amount from -maxChange to maxChange. With N molecules it is accepted with the
     * probability
     *
     *     min(1, exp(-(dU + P dV)/kT) (V'/V)^(N+1)).
     *
     * A trial recomputes the whole energy, so give this move a weight of about 1/N of the others. The Context's
     * periodic box vectors follow at the end of each step. setAdaptMoveSizes() finds a suitable size.
     *
     * It is an error, found when the Context is made, if the StericExclusionForce does not use periodic boundary
     * conditions, or a molecule has fixed particles; and, at the latest when a step begins, if the System has a
     * barostat or the temperature is 0. A box never becomes narrower than twice the largest cutoff of a Force, or than
     * twice the distance at which spheres clash: such trials are rejected, and a warning says so. Then use a larger
     * System, since it cannot reach the volumes that the pressure asks for.
     *
     * @param weight     how often this move is drawn, relative to the weights of the others, at least 0
     * @param pressure   the pressure, at least 0, in bar
     * @param maxChange  the largest change of ln V, above 0 and at most 1; 0.01 is about 1 % of the volume
     * @return the index of the move that was added
     */
    int addVolumeMove(double weight, double pressure, double maxChange);
    /**
     * Add a move that shifts and turns a group of molecules as one rigid body: a pair of chains, or a droplet, which
     * moves of single molecules could only dissolve and form elsewhere.
     *
     * Two molecules are neighbors if their centroids, in the nearest periodic images, are closer than a distance. A
     * group consists of all molecules of the list that are neighbors of each other, directly or by way of others. A
     * trial draws one molecule of the list, and a distance uniformly from 0 to maxDistance, so that groups of all sizes
     * occur. The group of this molecule is translated and rotated about the mean of its centroids, as in
     * addRigidBodyMove(). A group that is a neighbor of its own periodic image is translated only. In a periodic box, a
     * group of all molecules of the System stays where it is.
     *
     * A trial after which the group would have further members could not be reversed. Such a trial is impossible, and
     * counts as attempted only. So groups approach each other to within the drawn distance, and other moves join them.
     *
     * Molecules that are not in the list are in no group and do not keep others from moving.
     *
     * See Frenkel and Smit, Understanding Molecular Simulation, on cluster moves; Wu, Chandler and Smit, J. Phys. Chem.
     * 96, 4077 (1992).
     *
     * @param weight          how often this move is drawn, relative to the weights of the others, at least 0
     * @param maxTranslation  the largest translation, at least 0, in nm
     * @param maxAngle        the largest angle, from 0 to pi, in radians
     * @param maxDistance     the largest distance of the centroids of neighbors, at least 0, in nm
     * @param molecules       the molecules to choose from, each named by any one of its particles; if empty, all
     *                        molecules without fixed particles. In Python None means all of them, and an empty list is
     *                        an error.
     * @return the index of the move that was added
     */
    int addGroupMove(double weight, double maxTranslation, double maxAngle, double maxDistance,
                     const std::vector<int>& molecules = std::vector<int>());
    /**
     * Add a move that displaces single particles, so that bond lengths, bond angles and all other internal coordinates
     * change. Together with moves of torsions it samples exp(-U/kT) of all coordinates: the ensemble of dynamics
     * without constraints. The Forces have to hold the particles together; a System made by ForceField.createSystem()
     * needs constraints=None for this.
     *
     * A trial chooses one particle of the list, and shifts it by a vector that is uniform in a ball. Unless the
     * particle is a hydrogen, those bonded to it are shifted as well. A hydrogen is a particle of less than 4.5 amu
     * with a single bond in the StericExclusionForce. Hydrogens of the list have trials of their own. Virtual sites
     * follow the particles that define them.
     *
     * All other moves keep bond lengths and angles as this move has left them, and torsions turn about the present
     * lines between particles.
     *
     * Constraints of the System stay satisfied: particles joined by constraints move as one, and count as one particle
     * of the list. So rigid water is translated, and a hydrogen with a constraint has no trials of its own. Particles
     * of mass 0, and others in a rigid link with them, never move.
     *
     * Stiff particles need smaller trials than loose ones. Each class of trials, that is, of one mass that moves and
     * one number of bonds that change, has a scale of its own, which adapts in equilibration; see setAdaptMoveSizes()
     * and getMoveScales(). So add this move with a size that suits the loosest, such as 0.02 nm.
     *
     * Add the first such move before the Context is made. Only then are its links flexible: other Contexts are as fast
     * as ever.
     *
     * It is an error, found when the Context is made, if the list names a fixed particle, one in a rigid link with a
     * fixed particle, or a virtual site, or if constraints join particles of two links. A move that is added to a
     * Context without atom moves is an error.
     *
     * @param weight           how often this move is drawn, relative to the weights of the others, at least 0
     * @param maxDisplacement  the largest displacement, at least 0, in nm
     * @param particles        the indices of the particles to choose from; if empty, all that can move in molecules
     *                         with a radius, a torsion or a ball joint. In Python None means these, and an empty list
     * is an error.
     * @param withHydrogens    whether hydrogens follow the particle to which they are bonded
     * @return the index of the move that was added
     */
    int addAtomMove(double weight, double maxDisplacement, const std::vector<int>& particles = std::vector<int>(),
                    bool withHydrogens = true);
    /**
     * Get the number of moves.
     */
    int getNumMoves() const;
    /**
     * Get of which kind a move is.
     *
     * @param move  the index of the move
     */
    MoveType getMoveType(int move) const;
    /**
     * Get a line that describes a move: what moves and how far, its weight, and its choices.
     *
     * @param move  the index of the move
     */
    std::string getMoveDescription(int move) const;
    /**
     * Get the parameters of a move that was added by addTorsionMove(). It is an error if the move is of another kind.
     *
     * @param move           the index of the move
     * @param[out] weight    how often this move is drawn, relative to the weights of the others
     * @param[out] maxAngle  the largest angle, in radians
     * @param[out] torsions  the indices of the torsions to choose from; empty (in Python None) if they are all torsions
     * @param[out] count     the number of torsions that one trial turns
     */
    void getTorsionMoveParameters(int move, double& weight, double& maxAngle, std::vector<int>& torsions,
                                  int& count) const;
    /**
     * Get the parameters of a move that was added by addRigidBodyMove(). It is an error if the move is of another kind.
     *
     * @param move                 the index of the move
     * @param[out] weight          how often this move is drawn, relative to the weights of the others
     * @param[out] maxTranslation  the largest translation, in nm
     * @param[out] maxAngle        the largest angle, in radians
     * @param[out] molecules       the molecules to choose from, each named by one of its particles; empty (in Python
     *                             None) if they are all molecules without fixed particles
     */
    void getRigidBodyMoveParameters(int move, double& weight, double& maxTranslation, double& maxAngle,
                                    std::vector<int>& molecules) const;
    /**
     * Get the parameters of a move that was added by addClosedMove(). It is an error if the move is of another kind.
     *
     * @param move           the index of the move
     * @param[out] weight    how often this move is drawn, relative to the weights of the others
     * @param[out] maxAngle  the largest angle of a driver, in radians
     * @param[out] torsions  the indices of the torsions that windows may turn; empty (in Python None) for the torsions
     *                       of backbones and of rings
     * @param[out] hop       the share of trials that choose among all solutions
     */
    void getClosedMoveParameters(int move, double& weight, double& maxAngle, std::vector<int>& torsions,
                                 double& hop) const;
    /**
     * Get the parameters of a move that was added by addLocalMove(). It is an error if the move is of another kind.
     *
     * @param move            the index of the move
     * @param[out] weight     how often this move is drawn, relative to the weights of the others
     * @param[out] sigma      the standard deviation of the change of a torsion that shifts no end, in radians
     * @param[out] stiffness  how rare it is that the ends are shifted, in nm^-2
     * @param[out] torsions   the indices of the torsions that windows consist of; empty (in Python None) for the
     *                        torsions of all backbones
     * @param[out] window     the number of torsions of a window
     */
    void getLocalMoveParameters(int move, double& weight, double& sigma, double& stiffness, std::vector<int>& torsions,
                                int& window) const;
    /**
     * Get the parameters of a move that was added by addDrawnMove(). It is an error if the move is of another kind.
     *
     * @param move            the index of the move
     * @param[out] weight     how often this move is drawn, relative to the weights of the others
     * @param[out] torsions   the sets of torsions
     * @param[out] densities  the density of each set, or one density for all
     */
    void getDrawnMoveParameters(int move, double& weight, std::vector<std::vector<int>>& torsions,
                                std::vector<TorsionDensity>& densities) const;
    /**
     * Get the parameters of a move that was added by addPivotMove(). It is an error if the move is of another kind.
     *
     * @param move             the index of the move
     * @param[out] weight      how often this move is drawn, relative to the weights of the others
     * @param[out] maxAngle    the largest angle, in radians
     * @param[out] ballJoints  the indices of the ball joints to choose from; empty (in Python None) if they are all
     * ball joints
     */
    void getPivotMoveParameters(int move, double& weight, double& maxAngle, std::vector<int>& ballJoints) const;
    /**
     * Get the parameters of a move that was added by addCrankshaftMove(). It is an error if the move is of another
     * kind.
     *
     * @param move             the index of the move
     * @param[out] weight      how often this move is drawn, relative to the weights of the others
     * @param[out] maxAngle    the largest angle, in radians
     * @param[out] ballJoints  the indices of the ball joints to choose from; empty (in Python None) if they are all
     *                         ball joints
     * @param[out] window      the largest number of ball joints from one end to the other
     */
    void getCrankshaftMoveParameters(int move, double& weight, double& maxAngle, std::vector<int>& ballJoints,
                                     int& window) const;
    /**
     * Get the parameters of a move that was added by addVolumeMove(). It is an error if the move is of another kind.
     *
     * @param move            the index of the move
     * @param[out] weight     how often this move is drawn, relative to the weights of the others
     * @param[out] pressure   the pressure, in bar
     * @param[out] maxChange  the largest change of the logarithm of the volume
     */
    void getVolumeMoveParameters(int move, double& weight, double& pressure, double& maxChange) const;
    /**
     * Get the parameters of a move that was added by addGroupMove(). It is an error if the move is of another kind.
     *
     * @param move                 the index of the move
     * @param[out] weight          how often this move is drawn, relative to the weights of the others
     * @param[out] maxTranslation  the largest translation, in nm
     * @param[out] maxAngle        the largest angle, in radians
     * @param[out] maxDistance     the largest distance of the centroids of neighbors, in nm
     * @param[out] molecules       the molecules to choose from, each named by one of its particles; empty (in Python
     *                             None) if they are all molecules without fixed particles
     */
    void getGroupMoveParameters(int move, double& weight, double& maxTranslation, double& maxAngle, double& maxDistance,
                                std::vector<int>& molecules) const;
    /**
     * Get the parameters of a move that was added by addAtomMove(). It is an error if the move is of another kind.
     *
     * @param move                  the index of the move
     * @param[out] weight           how often this move is drawn, relative to the weights of the others
     * @param[out] maxDisplacement  the largest displacement, in nm
     * @param[out] particles        the indices of the particles to choose from; empty (in Python None) if they are all
     *                              that can move in molecules with a radius or a joint
     * @param[out] withHydrogens    whether hydrogens follow the particle to which they are bonded
     */
    void getAtomMoveParameters(int move, double& weight, double& maxDisplacement, std::vector<int>& particles,
                               bool& withHydrogens) const;
    /**
     * Set the parameters of a move that was added by addTorsionMove(). It is an error if the move is of another kind.
     * The next trial follows them. The counts of the move restart from 0.
     *
     * @param move      the index of the move
     * @param weight    how often this move is drawn, relative to the weights of the others, at least 0
     * @param maxAngle  the largest angle, from 0 to pi, in radians; with pi the new angle is independent of the old one
     * @param torsions  the indices of the torsions of the StericExclusionForce to choose from; if empty, all of them.
     *                  In Python None means all of them, and an empty list is an error.
     * @param count     the number of torsions that one trial turns
     */
    void setTorsionMoveParameters(int move, double weight, double maxAngle,
                                  const std::vector<int>& torsions = std::vector<int>(), int count = 1);
    /**
     * Set the parameters of a move that was added by addRigidBodyMove(). It is an error if the move is of another kind.
     * The next trial follows them. The counts of the move restart from 0.
     *
     * @param move            the index of the move
     * @param weight          how often this move is drawn, relative to the weights of the others, at least 0
     * @param maxTranslation  the largest translation, at least 0, in nm
     * @param maxAngle        the largest angle, from 0 to pi, in radians
     * @param molecules       the molecules to choose from, each named by any one of its particles; if empty, all
     *                        molecules without fixed particles. In Python None means all of them, and an empty list is
     *                        an error.
     */
    void setRigidBodyMoveParameters(int move, double weight, double maxTranslation, double maxAngle,
                                    const std::vector<int>& molecules = std::vector<int>());
    /**
     * Set the parameters of a move that was added by addClosedMove(). It is an error if the move is of another kind.
     * The next trial follows them. The counts of the move restart from 0.
     *
     * @param move      the index of the move
     * @param weight    how often this move is drawn, relative to the weights of the others, at least 0
     * @param maxAngle  the largest angle of a driver, from 0 to pi, in radians
     * @param torsions  the indices of the torsions of the StericExclusionForce that windows may turn; if empty, the
     *                  torsions of all backbones and of rings of closures. In Python None means these, and an empty
     *                  list is an error.
     * @param hop       the share of trials that choose among all solutions, from 0 to 1
     */
    void setClosedMoveParameters(int move, double weight, double maxAngle,
                                 const std::vector<int>& torsions = std::vector<int>(), double hop = 0.2);
    /**
     * Set the parameters of a move that was added by addLocalMove(), which explains them. It is an error if the move is
     * of another kind. The next trial follows them. The counts of the move restart from 0.
     *
     * @param move       the index of the move
     * @param weight     how often this move is drawn, relative to the weights of the others, at least 0
     * @param sigma      the standard deviation of the change of a torsion that shifts no end, above 0 and at most pi,
     *                   in radians
     * @param stiffness  how rare it is that the ends are shifted, at least 0, in nm^-2
     * @param torsions   the indices of the torsions that windows consist of; if empty, the torsions of all backbones.
     *                   In Python None means these, and an empty list is an error.
     * @param window     the number of torsions of a window, from 1 to 32
     */
    void setLocalMoveParameters(int move, double weight, double sigma, double stiffness,
                                const std::vector<int>& torsions = std::vector<int>(), int window = 8);
    /**
     * Set the parameters of a move that was added by addDrawnMove(). It is an error if the move is of another kind. The
     * next trial follows them. The counts of the move restart from 0.
     *
     * @param move       the index of the move
     * @param weight     how often this move is drawn, relative to the weights of the others, at least 0
     * @param torsions   the sets of torsions
     * @param densities  the density of each set, or one density for all
     */
    void setDrawnMoveParameters(int move, double weight, const std::vector<std::vector<int>>& torsions,
                                const std::vector<TorsionDensity>& densities);
    /**
     * Set the parameters of a move that was added by addPivotMove(). It is an error if the move is of another kind. The
     * next trial follows them. The counts of the move restart from 0.
     *
     * @param move        the index of the move
     * @param weight      how often this move is drawn, relative to the weights of the others, at least 0
     * @param maxAngle    the largest angle, from 0 to pi, in radians; with pi the new direction is independent of the
     * old one
     * @param ballJoints  the indices of the ball joints of the StericExclusionForce to choose from; if empty, all of
     *                    them. In Python None means all of them, and an empty list is an error.
     */
    void setPivotMoveParameters(int move, double weight, double maxAngle,
                                const std::vector<int>& ballJoints = std::vector<int>());
    /**
     * Set the parameters of a move that was added by addCrankshaftMove(), which explains them. It is an error if the
     * move is of another kind. The next trial follows them. The counts of the move restart from 0.
     *
     * @param move        the index of the move
     * @param weight      how often this move is drawn, relative to the weights of the others, at least 0
     * @param maxAngle    the largest angle, from 0 to pi, in radians
     * @param ballJoints  the indices of the ball joints of the StericExclusionForce to choose from; if empty, all of
     *                    them. In Python None means all of them, and an empty list is an error.
     * @param window      the largest number of ball joints from one end to the other, at least 2
     */
    void setCrankshaftMoveParameters(int move, double weight, double maxAngle,
                                     const std::vector<int>& ballJoints = std::vector<int>(), int window = 8);
    /**
     * Set the parameters of a move that was added by addVolumeMove(), which explains them. It is an error if the move
     * is of another kind. The next trial follows them. The counts of the move restart from 0.
     *
     * @param move       the index of the move
     * @param weight     how often this move is drawn, relative to the weights of the others, at least 0
     * @param pressure   the pressure, at least 0, in bar
     * @param maxChange  the largest change of ln V, above 0 and at most 1
     */
    void setVolumeMoveParameters(int move, double weight, double pressure, double maxChange);
    /**
     * Set the parameters of a move that was added by addGroupMove(), which explains them. It is an error if the move is
     * of another kind. The next trial follows them. The counts of the move restart from 0.
     *
     * @param move            the index of the move
     * @param weight          how often this move is drawn, relative to the weights of the others, at least 0
     * @param maxTranslation  the largest translation, at least 0, in nm
     * @param maxAngle        the largest angle, from 0 to pi, in radians
     * @param maxDistance     the largest distance of the centroids of neighbors, at least 0, in nm
     * @param molecules       the molecules to choose from, each named by any one of its particles; if empty, all
     *                        molecules without fixed particles. In Python None means all of them, and an empty list is
     *                        an error.
     */
    void setGroupMoveParameters(int move, double weight, double maxTranslation, double maxAngle, double maxDistance,
                                const std::vector<int>& molecules = std::vector<int>());
    /**
     * Set the parameters of a move that was added by addAtomMove(), which explains them. It is an error if the move is
     * of another kind. The next trial follows them. The counts of the move restart from 0, and its scales from 1.
     *
     * @param move             the index of the move
     * @param weight           how often this move is drawn, relative to the weights of the others, at least 0
     * @param maxDisplacement  the largest displacement, at least 0, in nm
     * @param particles        the indices of the particles to choose from; if empty, all that can move in molecules
     *                         with a radius, a torsion or a ball joint. In Python None means these, and an empty list
     * is an error.
     * @param withHydrogens    whether hydrogens follow the particle to which they are bonded
     */
    void setAtomMoveParameters(int move, double weight, double maxDisplacement,
                               const std::vector<int>& particles = std::vector<int>(), bool withHydrogens = true);
    /**
     * Remove a move, and its counts. The indices of the moves after it become lower by one.
     *
     * @param move  the index of the move
     */
    void removeMove(int move);
    /**
     * Get the results of the trials of a move, since the move was added, its parameters were set or
     * resetMoveStatistics() was called. Trials that an outer test has undone do not count.
     *
     * @param move                    the index of the move
     * @param[out] attempted          the number of trials: the sum of the other three, and of impossible trials, for
     *                                example of a window that does not close or that has no reverse
     * @param[out] clashed            the number of trials rejected because a pair overlapped beyond its limit
     * @param[out] rejectedByEnergy   the number of trials without a clash rejected by U or by the density of the
     *                                reverse move, or because U was not a number
     * @param[out] accepted           the number of trials accepted
     */
    void getMoveStatistics(int move, long long& attempted, long long& clashed, long long& rejectedByEnergy,
                           long long& accepted) const;
    /**
     * Set the counts of all moves, of getStageStatistics() and of getOuterStatistics() to 0.
     */
    void resetMoveStatistics();
    /**
     * Get whether the sizes of moves adapt. The default is false.
     */
    bool getAdaptMoveSizes() const;
    /**
     * Set whether the sizes of moves adapt to an acceptance of 40 percent, or 25 percent for atom moves. Use this in
     * equilibration only: while sizes adapt, the sampled distribution is not exact.
     *
     * The parameters of a move are its largest sizes. Each move has a scale, at most 1, by which they are multiplied;
     * after every 100 trials of the move it decreases if too few trials were accepted, and increases if too many were.
     * So add moves whose sizes are too large rather than too small. An impossible trial counts as not accepted, and a
     * trial that an outer test undoes counts as it was decided before. Moves without a size do not adapt.
     *
     * After setAdaptMoveSizes(false), each move keeps the scale that getMoveScale() returns. The counts of
     * getMoveStatistics(), getStageStatistics() and getOuterStatistics() restart from 0 both when adaptation begins and
     * when it ends, to separate equilibration from sampling. Checkpoints, States and the XML of this integrator hold
     * the scales.
     *
     * @code
     * integrator.setAdaptMoveSizes(true);
     * integrator.step(1000);
     * integrator.setAdaptMoveSizes(false);
     * integrator.step(100000);
     * @endcode
     *
     * @param adapt  whether sizes adapt from now on
     */
    void setAdaptMoveSizes(bool adapt);
    /**
     * Get the factor by which the sizes of a move are multiplied: 1 unless they have adapted, or setMoveScale() has set
     * it. The present sizes are this times the parameters of the move: its maxAngle, maxTranslation or sigma. Of an
     * atom move it is the geometric mean of getMoveScales().
     *
     * @param move  the index of the move
     */
    double getMoveScale(int move) const;
    /**
     * Set the factor by which the sizes of a move are multiplied, for example to the result of getMoveScale() in
     * another run. Setting the parameters of a move makes it 1. The counts of the move restart from 0. It is an error
     * if the move has no size.
     *
     * @param move   the index of the move
     * @param scale  the factor, above 0 and at most 1
     */
    void setMoveScale(int move, double scale);
    /**
     * Get the factors by which the sizes of the classes of a move are multiplied. Once there is a Context, an atom move
     * has a class for each mass that it moves and each number of bonds that it changes by that, in ascending order of
     * the mass, then of the number. All other moves have one class.
     *
     * @param move         the index of the move
     * @param[out] scales  the factor of each class
     */
    void getMoveScales(int move, std::vector<double>& scales) const;
    /**
     * Set the factors of the classes of a move, for example to the result of getMoveScales() in another run. The counts
     * of the move restart from 0. It is an error if the move has no size; and, at the latest when the Context is made,
     * if it has another number of classes.
     *
     * @param move    the index of the move
     * @param scales  the factor of each class, above 0 and at most 1
     */
    void setMoveScales(int move, const std::vector<double>& scales);
    /**
     * Get the values of all torsions. The same as StericExclusionForce::getTorsionAngles().
     *
     * @param context      the Context that this integrator is bound to
     * @param[out] angles  the value of each torsion, in (-pi, pi], in radians
     */
    void getTorsionAngles(OpenMM::Context& context, std::vector<double>& angles) const;
    /**
     * Turn all torsions to given values, even if this makes clashes. The same as
     * StericExclusionForce::setTorsionAngles().
     *
     * @param context  the Context that this integrator is bound to
     * @param angles   the value of each torsion, in radians
     */
    void setTorsionAngles(OpenMM::Context& context, const std::vector<double>& angles) const;
    /**
     * Throw an exception if the Context has velocities that cannot turn with links, and name the constraint that
     * prevents it. Beside dynamics no such Context can be created. Otherwise steps do not change such velocities, and
     * warn; call this before dynamics in another Context continues from them.
     *
     * @param context  the Context that this integrator is bound to
     */
    void checkVelocities(OpenMM::Context& context) const;
    /**
     * Advance the simulation by taking a series of steps, of getTrialsPerStep() trials each.
     *
     * @param steps  the number of steps to take
     */
    void step(int steps);

protected:
    void initialize(OpenMM::ContextImpl& context);
    void cleanup();
    std::vector<std::string> getKernelNames();
    void stateChanged(OpenMM::State::DataType changed);
    double computeKineticEnergy();
    bool kineticEnergyRequiresForce() const
    {
        return false;
    }
    void createCheckpoint(std::ostream& stream) const;
    void loadCheckpoint(std::istream& stream);
    void serializeParameters(OpenMM::SerializationNode& node) const;
    void deserializeParameters(const OpenMM::SerializationNode& node);

    /**
     * Add a move of any kind. Returns its index.
     */
    int addMove(std::unique_ptr<MonteCarloMove> move, double weight);
    /**
     * Get the stages that decide trials without a clash. They exist while the integrator is bound to a Context.
     */
    EnergyStages& getEnergyStages()
    {
        return *stages;
    }

private:
    friend class TorsionMonteCarloIntegratorProxy;
    class KeptState;
    std::unique_ptr<KeptState> keepState();
    void showKeptState() const;
    void restoreCheckpoint(CheckpointReader& reader, int version, bool positionsAreSafe);
    std::unique_ptr<KeptGeometry> readGeometry(const OpenMM::SerializationNode& state, int version) const;
    void bindTo(OpenMM::ContextImpl& context);
    void setMove(int index, std::unique_ptr<MonteCarloMove> move, double weight);
    void resetStatistics();
    void checkBeforeSteps();
    void updateContextState();
    int runTrials(int begin, SignalWatch& signals);
    void requireBound() const;
    void requireContext(const OpenMM::Context& context) const;
    void bindEnergies(StericExclusionForceImpl& force, OpenMM::ContextImpl& context);
    std::unique_ptr<MoveList> moves;
    bool adaptMoveSizes;
    double temperature;
    int randomNumberSeed, trialsPerStep;
    InitialClashPolicy initialClashPolicy;
    StericMode stericMode;
    bool nativeEnergies;
    int trialsPerOuterTest;
    double standInBornCutoff, standInPairCutoff, standInGridWidth;
    std::unique_ptr<OuterStatistics> outerStatistics;
    /** The state of a Context whose reinitialize() has not succeeded yet, else NULL. */
    std::unique_ptr<KeptState> kept;
    /** The Context's lock, if there is a Context. */
    std::shared_ptr<ContextLock> lock;
    /** The time per trial in the last steps, for the watch for signals. */
    double secondsPerTrial;
    // The rest exists only while the integrator is bound to a Context.
    StericExclusionForceImpl* force;
    /** Expires when the force does: before cleanup() if a Context ends, after it if it is reinitialized. */
    std::weak_ptr<const void> forceLife;
    bool contextHasEnded = false;
    /** Whether another kind of Integrator is in the Context; whether the user was warned of hard spheres; and whether
     *  constraints were checked. */
    bool isBesideDynamics, hasWarnedOfHardSpheres, constraintsAreChecked;
    std::unique_ptr<NativeEnergy> native;
    std::unique_ptr<EnergyStages> stages;
    std::unique_ptr<RandomNumberGenerator> random;
    OpenMM::Kernel kernel;
    /** The positions that a checkpoint has restored, until the Context reports them; else empty. */
    std::vector<OpenMM::Vec3> restoredPositions;
};

} // namespace ChainTreePlugin

#endif /*OPENMM_TORSIONMONTECARLOINTEGRATOR_H_*/
