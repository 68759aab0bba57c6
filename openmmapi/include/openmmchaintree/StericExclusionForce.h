#ifndef OPENMM_STERICEXCLUSIONFORCE_H_
#define OPENMM_STERICEXCLUSIONFORCE_H_

#include "internal/windowsExportChainTree.h"
#include "openmm/Context.h"
#include "openmm/Force.h"
#include "openmm/Vec3.h"
#include <array>
#include <utility>
#include <vector>

namespace ChainTreePlugin {

/**
 * This class treats particles as spheres: it finds clashes and neighbour pairs, tests trials of torsion-space Monte
 * Carlo for clashes, and has an energy that pushes clashing particles apart.
 *
 * The <i>overlap</i> of two particles with radii r_i and r_j whose centres are d_ij apart is
 *
 *     overlap_ij = r_i + r_j - d_ij
 *
 * and the pair is a <i>clash</i> if
 *
 *     overlap_ij > tolerance_ij,   tolerance_ij = overlapTolerance + (hydrogenBondAllowance, if one of the two
 *                                                 may donate a hydrogen bond and the other may accept it)
 *
 * Excluded pairs never clash, nor does a particle of radius 0, which moves with its link but is not modelled.
 * The energy is
 *
 *     E = 1/2 k * (sum over clashes) (overlap_ij - tolerance_ij)^2
 *
 * and the forces are its exact gradient (two particles at the same place are pushed apart along x). All lengths are in
 * nm, angles in radians, energies in kJ/mol.
 *
 * <b>Describing the molecules.</b> Call addParticle() once for each particle of the System. Then describe how the
 * particles are connected: addBond() for every bond, addTorsion() for each rotatable bond, and addBallJoint() for each
 * bond that may take any direction, as in chains of beads. Other bonds are rigid. Particles that no torsion or ball
 * joint moves relative to each other form a rigid <i>link</i>; a molecule without torsions and ball joints is one rigid
 * body. Exclude bonded neighbours by createExclusionsFromBonds().
 *
 * A particle of mass 0 that is not a virtual site is <i>fixed</i>. The fixed particles of a molecule must all lie in
 * one link; that link never moves. In a molecule without fixed particles the link with the lowest-numbered particle
 * takes this role. A torsion or ball joint moves the side without that link. A virtual site moves with the particles
 * that define it.
 *
 * <b>Rings and loops.</b> Bonds and torsions make a tree: no torsion can be about a bond in a ring, or between two
 * fixed parts. A <i>closure</i> is a bond of a ring that is added by addClosure() instead of addBond(). Closed
 * moves then turn the torsions of a disulfide's ring, of a cyclic peptide, or of a loop between fixed parts, and keep
 * the closure.
 *
 * <b>Queries.</b> hasClash(), getClashes(), getNeighborPairs(), getMinimumDistance() and getClashesWith() use the
 * present positions of a Context, whoever set them, and cover every pair.
 *
 * <b>Trials, to write your own Monte Carlo.</b> proposeTorsions(), proposeBallRotations() and proposeRigidMotion()
 * propose a trial and return whether it is free of clashes, usually in microseconds and without moving anything.
 * acceptProposal() then moves the Context there, and rejectProposal() ends the trial. There is one trial at a time: the
 * next one, a step of a TorsionMonteCarloIntegrator, or any other change of positions rejects it.
 *
 * @code
 * StericExclusionForce* force = new StericExclusionForce();
 * // addParticle(), addBond(), addTorsion() ...
 * force->createExclusionsFromBonds(3);
 * system.addForce(force);
 * // ... create a Context and set positions
 * if (force->proposeTorsions(context, {3}, {0.2}))
 *     force->acceptProposal(context);
 * @endcode
 *
 * <b>Limits.</b> A trial is rejected if a pair overlaps beyond its <i>limit</i>. A pair's limit is its tolerance,
 * unless it clashes when sampling starts, that is, at the first trial after the Context was created or the user set
 * positions: then its limit is its overlap at that time. So structures with a few clashes can be sampled, and no clash
 * gets worse. Accepting a proposal that clashes restarts limits from the accepted positions, and restartLimits() from
 * the present ones. getClashes() and hasClash() always use the tolerance.
 *
 * In a Context driven by a TorsionMonteCarloIntegrator, limits may grow but never shrink if another Integrator of a
 * CompoundIntegrator has moved particles, or a Force at the beginning of a step. Integrators
 * announce each step to all Forces, and the Context reports positions that are set. Other changes of positions
 * (Context::applyConstraints(), and the minimizer on GPU platforms) count as set by the user; they can be told from
 * dynamics if the StericExclusionForce or the sampler has read the positions in between. Only a CustomIntegrator
 * without addUpdateContextState() does not announce its steps: beside one, limits only grow unless positions are set or
 * restartLimits() is called. Checkpoints and States hold limits only with a TorsionMonteCarloIntegrator. Without one,
 * every change of positions other than by a proposal restarts the limits.
 *
 * <b>Periodic boundary conditions.</b> With setUsesPeriodicBoundaryConditions(true), every pair of particles counts in
 * all periodic images: a particle may clash with an image of another one, also of its own molecule. An exclusion holds
 * in all images of its pair. The box is the Context's. A change of its vectors takes effect at the next query,
 * proposal or step: it rejects an open proposal, and limits may grow but not shrink. Half the box's width (the least
 * distance between opposite faces, which is the smallest of ax, by and cz) must be at least the largest distance at
 * which two particles clash, and the cutoff of each query. Molecules may be anywhere, but must be whole, as they are in
 * the Context: bonds connect positions as they are given, not their images.
 *
 * By default, distances are those between the given positions, and images do not count. If another Force of the
 * System then uses periodic boundary conditions, creating a Context warns of this: on the standard error stream, or in
 * Python by a UserWarning.
 *
 * The force keeps no state, so several Contexts may share it. Changing it after a Context was created has no effect on
 * that Context until updateParametersInContext() is called.
 */
class OPENMM_EXPORT_CHAINTREE StericExclusionForce : public OpenMM::Force {
public:
    /**
     * The role of a particle in hydrogen bonds. If hydrogens are modelled, give roles to the hydrogens that can be
     * donated and to the atoms that accept them, else to heavy atoms.
     */
    enum HydrogenBondRole {
        /**
         * The particle takes part in no hydrogen bond.
         */
        NoHydrogenBond = 0,
        /**
         * The particle may donate a hydrogen bond.
         */
        Donor = 1,
        /**
         * The particle may accept a hydrogen bond.
         */
        Acceptor = 2,
        /**
         * The particle may do either.
         */
        DonorAndAcceptor = 3
    };
    /**
     * Create a StericExclusionForce without particles.
     */
    StericExclusionForce();
    /**
     * Get the number of particles for which parameters have been defined.
     */
    int getNumParticles() const;
    /**
     * Get the number of bonds.
     */
    int getNumBonds() const;
    /**
     * Get the number of torsions.
     */
    int getNumTorsions() const;
    /**
     * Get the number of ball joints.
     */
    int getNumBallJoints() const;
    /**
     * Get the number of closures.
     */
    int getNumClosures() const;
    /**
     * Get the number of exclusions, as they were added.
     */
    int getNumExclusions() const;
    /**
     * Add a particle. Call this once for each particle of the System: particle i of this force is particle i of the
     * System.
     *
     * @param radius            the radius of the sphere, in nm. A particle of radius 0 is not modelled: it takes
     *                          part in no clash and is in no list of neighbours, but moves with its link.
     * @param hydrogenBondRole  the role of the particle in hydrogen bonds
     * @return the index of the particle that was added
     */
    int addParticle(double radius, HydrogenBondRole hydrogenBondRole = NoHydrogenBond);
    /**
     * Get the parameters of a particle.
     *
     * @param index                  the index of the particle
     * @param[out] radius            the radius of the sphere, in nm
     * @param[out] hydrogenBondRole  the role of the particle in hydrogen bonds
     */
    void getParticleParameters(int index, double& radius, HydrogenBondRole& hydrogenBondRole) const;
    /**
     * Set the parameters of a particle.
     *
     * @param index             the index of the particle
     * @param radius            the radius of the sphere, in nm
     * @param hydrogenBondRole  the role of the particle in hydrogen bonds
     */
    void setParticleParameters(int index, double radius, HydrogenBondRole hydrogenBondRole = NoHydrogenBond);
    /**
     * Add a bond. Bonds decide which particles form a molecule and which move together. Adding a bond twice is
     * harmless.
     *
     * @param particle1  the index of the first particle
     * @param particle2  the index of the second particle
     * @return the index of the bond that was added
     */
    int addBond(int particle1, int particle2);
    /**
     * Get the particles of a bond.
     *
     * @param index           the index of the bond
     * @param[out] particle1  the index of the first particle
     * @param[out] particle2  the index of the second particle
     */
    void getBondParticles(int index, int& particle1, int& particle2) const;
    /**
     * Add a torsion: a rotation about the bond between particle2 and particle3. Its value is the IUPAC dihedral of the
     * four particles, in (-pi, pi]: 0 if particle1 and particle4 are cis.
     *
     * The four particles must be bonded in a row. When a Context is created it is an error if the bond lies in a ring,
     * if there is another torsion about it, or if particles on both sides of it are fixed.
     *
     * @param particle1  the index of a particle bonded to particle2
     * @param particle2  the index of the first particle of the axis
     * @param particle3  the index of the second particle of the axis
     * @param particle4  the index of a particle bonded to particle3
     * @return the index of the torsion that was added
     */
    int addTorsion(int particle1, int particle2, int particle3, int particle4);
    /**
     * Get the particles of a torsion.
     *
     * @param index           the index of the torsion
     * @param[out] particle1  the index of a particle bonded to particle2
     * @param[out] particle2  the index of the first particle of the axis
     * @param[out] particle3  the index of the second particle of the axis
     * @param[out] particle4  the index of a particle bonded to particle3
     */
    void getTorsionParticles(int index, int& particle1, int& particle2, int& particle3, int& particle4) const;
    /**
     * Add a ball joint: the two sides of the bond between particle1 and particle2 can rotate relative to each other in
     * any way about particle1, which keeps its place in both. The bond keeps its length, but angles at particle1
     * change. A chain of beads has one ball joint for each bond, with particle1 the bead nearer to the root (the
     * lowest-numbered particle, or the fixed ones): then every bond can take any direction.
     *
     * The two particles must be bonded. When a Context is created it is an error if the bond lies in a ring, if there
     * is another ball joint or a torsion about it (which a ball joint comprises), if particles on both sides of it are
     * fixed, or if a torsion names particle2 as the particle next to the end particle1 of its axis, because the ball
     * joint would change its value.
     *
     * @param particle1  the index of the particle about which the sides turn
     * @param particle2  the index of a particle bonded to particle1
     * @return the index of the ball joint that was added
     */
    int addBallJoint(int particle1, int particle2);
    /**
     * Get the particles of a ball joint.
     *
     * @param index           the index of the ball joint
     * @param[out] particle1  the index of the particle about which the sides turn
     * @param[out] particle2  the index of a particle bonded to particle1
     */
    void getBallJointParticles(int index, int& particle1, int& particle2) const;
    /**
     * Add a closure: a bond between particle2 and particle3 that closes a ring, or a loop between fixed parts, and must
     * not be among the bonds. The links of particle2 and particle3 keep their relative placement, and with it the
     * bond's length, its angles and its dihedral.
     *
     * Only closed moves (TorsionMonteCarloIntegrator::addClosedMove()) turn the torsions of the ring, in windows that
     * keep the closure. Other moves do not turn them; a move that names them is an error, and so are proposeTorsions()
     * and setTorsionAngles() that turn them.
     *
     * When a Context is created it is an error if particle1 and particle2, or particle3 and particle4, are not bonded,
     * if particle2 and particle3 are, if the bond has a closure already, or if particle2 and particle3 belong to
     * different molecules of which one has no fixed particles: then only the bond would hold them together.
     *
     * @param particle1  the index of a particle bonded to particle2
     * @param particle2  the index of the first particle of the bond
     * @param particle3  the index of the second particle of the bond
     * @param particle4  the index of a particle bonded to particle3
     * @return the index of the closure that was added
     */
    int addClosure(int particle1, int particle2, int particle3, int particle4);
    /**
     * Get the particles of a closure.
     *
     * @param index           the index of the closure
     * @param[out] particle1  the index of a particle bonded to particle2
     * @param[out] particle2  the index of the first particle of the bond
     * @param[out] particle3  the index of the second particle of the bond
     * @param[out] particle4  the index of a particle bonded to particle3
     */
    void getClosureParticles(int index, int& particle1, int& particle2, int& particle3, int& particle4) const;
    /**
     * Exclude a pair of particles: it never clashes and is in no list of neighbours. Excluding a pair twice is
     * harmless.
     *
     * @param particle1  the index of the first particle
     * @param particle2  the index of the second particle
     * @return the index of the exclusion that was added
     */
    int addExclusion(int particle1, int particle2);
    /**
     * Get the particles of an exclusion.
     *
     * @param index           the index of the exclusion
     * @param[out] particle1  the index of the first particle
     * @param[out] particle2  the index of the second particle
     */
    void getExclusionParticles(int index, int& particle1, int& particle2) const;
    /**
     * Exclude all pairs of particles that are up to a number of bonds apart, along the bonds and closures added so far.
     * Pairs that are excluded already are not added again.
     *
     * @param bondCutoff  the largest number of bonds between two excluded particles. 3 is usual: it excludes particles
     *                    whose distance bond lengths, bond angles and one torsion decide.
     */
    void createExclusionsFromBonds(int bondCutoff);
    /**
     * Get the overlap that every pair may have, in nm. The default is 0.04 nm.
     */
    double getOverlapTolerance() const;
    /**
     * Set the overlap that every pair may have.
     *
     * @param tolerance  the overlap, at least 0, in nm
     */
    void setOverlapTolerance(double tolerance);
    /**
     * Get the overlap that is allowed in addition where one particle may donate a hydrogen bond to the other, in nm.
     * The default is 0.06 nm.
     */
    double getHydrogenBondAllowance() const;
    /**
     * Set the overlap that is allowed in addition where one particle may donate a hydrogen bond to the other.
     *
     * @param allowance  the additional overlap, at least 0, in nm
     */
    void setHydrogenBondAllowance(double allowance);
    /**
     * Get the force constant k of the energy, in kJ/mol/nm^2. The default is 1e5 kJ/mol/nm^2.
     */
    double getForceConstant() const;
    /**
     * Set the force constant k of the energy. It does not influence which pairs clash.
     *
     * @param k  the force constant, at least 0, in kJ/mol/nm^2
     */
    void setForceConstant(double k);
    /**
     * Set whether every pair of particles counts in all images of the Context's periodic box. The default is false.
     *
     * @param periodic  whether this force uses periodic boundary conditions
     */
    void setUsesPeriodicBoundaryConditions(bool periodic);
    /**
     * Get whether every pair of particles counts in all images of the Context's periodic box.
     */
    bool usesPeriodicBoundaryConditions() const;
    /**
     * Copy radii, hydrogen bond roles, the overlap tolerance, the hydrogen bond allowance and the force constant to a
     * Context. A proposed trial is rejected. A limit above the pair's new tolerance is kept if both radii are above 0,
     * and limits grow at the next trial if the new parameters make new clashes.
     *
     * Bonds, torsions, ball joints, closures, exclusions and the number of particles cannot be changed this way: if
     * they have changed since the Context was created, this throws an exception. Reinitialize the Context instead.
     * (Existing bonds and exclusions may be repeated.) After an exception the Context is unchanged, and keeps the
     * proposed trial. Whether the force uses periodic boundary conditions is not copied either; it applies from the
     * next Context::reinitialize().
     *
     * This takes O(N log N) time.
     *
     * @param context  the Context whose parameters are to be updated
     */
    void updateParametersInContext(OpenMM::Context& context);
    /**
     * Get whether any pair of particles clashes, at the present positions. This is faster than getClashes(): it stops
     * at the first clash. With periodic boundary conditions, images count.
     *
     * @param context  the Context whose positions are used
     */
    bool hasClash(OpenMM::Context& context) const;
    /**
     * Get all clashes, at the present positions. With periodic boundary conditions, images count: two particles clash
     * in at most one image.
     *
     * @param context        the Context whose positions are used
     * @param[out] pairs     the pairs that clash, sorted, in each of them the lower index first
     * @param[out] overlaps  the overlap of each pair, in nm. It is larger than the tolerance of the pair.
     */
    void getClashes(OpenMM::Context& context, std::vector<std::pair<int, int>>& pairs,
                    std::vector<double>& overlaps) const;
    /**
     * Get all pairs of particles within a cutoff distance of each other, centre to centre, at the present positions.
     * Excluded pairs and particles of radius 0 are left out. With periodic boundary conditions, distances are those of
     * the nearest images, and the cutoff is at most half the box's width.
     *
     * @param context         the Context whose positions are used
     * @param cutoff          the largest distance, above 0, in nm
     * @param[out] pairs      the pairs within the cutoff, sorted, in each of them the lower index first
     * @param[out] distances  the distance of each pair, in nm
     */
    void getNeighborPairs(OpenMM::Context& context, double cutoff, std::vector<std::pair<int, int>>& pairs,
                          std::vector<double>& distances) const;
    /**
     * Get the least distance, centre to centre, between a particle of one set and a different particle of another, at
     * the present positions. Unlike the other queries this one includes excluded pairs and particles of radius 0. With
     * periodic boundary conditions, it is the least distance between all images, however wide the box is; a particle
     * and its own image are no pair.
     *
     * The time is about proportional to the sizes of the two sets, since groups of particles farther apart than the
     * nearest pair found are skipped as a whole.
     *
     * @param context         the Context whose positions are used
     * @param particles1      the indices of the particles in the first set
     * @param particles2      the indices of the particles in the second set
     * @param[out] particle1  the particle of the first set that is nearest to one of the second
     * @param[out] particle2  that particle of the second set
     * @return the distance, in nm
     */
    double getMinimumDistance(OpenMM::Context& context, const std::vector<int>& particles1,
                              const std::vector<int>& particles2, int& particle1, int& particle2) const;
    /**
     * Get the particles that overlap a probe, a sphere that is no particle, by more than the overlap tolerance. The
     * hydrogen bond allowance is not used. With periodic boundary conditions, images of particles count. Half the
     * box's width must then be at least the largest distance at which the probe clashes.
     *
     * @param context         the Context whose positions are used
     * @param position        the centre of the probe, in nm
     * @param radius          the radius of the probe, at least 0, in nm
     * @param[out] particles  the particles that the probe clashes with, sorted
     * @param[out] overlaps   the overlap of each of them with the probe, in nm
     */
    void getClashesWith(OpenMM::Context& context, const OpenMM::Vec3& position, double radius,
                        std::vector<int>& particles, std::vector<double>& overlaps) const;
    /**
     * Propose a trial that turns torsions, and test it. Nothing moves until acceptProposal() is called. For k torsions
     * this usually takes O(k log N) time, and less if there is a clash. It is an error if a torsion lies in the ring of
     * a closure.
     *
     * @param context   the Context whose positions are the start
     * @param torsions  the indices of the torsions to turn, each at most once
     * @param changes   the change of the value of each of these torsions, in radians
     * @return true if no pair whose distance the trial changes overlaps beyond its limit
     */
    bool proposeTorsions(OpenMM::Context& context, const std::vector<int>& torsions,
                         const std::vector<double>& changes) const;
    /**
     * Propose a trial that turns ball joints, and test it. Nothing moves until acceptProposal() is called. For k ball
     * joints this usually takes O(k log N) time, and less if there is a clash.
     *
     * Each rotation is about the position of its particle before the trial. If one joint moves the particle of another,
     * the joint nearer to the root turns last and moves the result of the other one.
     *
     * @param context     the Context whose positions are the start
     * @param ballJoints  the indices of the ball joints to turn, each at most once
     * @param rotations   the rotation of the side that moves, for each of these joints: a vector along the axis whose
     *                    length is the angle, in radians
     * @return true if no pair whose distance the trial changes overlaps beyond its limit
     */
    bool proposeBallRotations(OpenMM::Context& context, const std::vector<int>& ballJoints,
                              const std::vector<OpenMM::Vec3>& rotations) const;
    /**
     * Propose a trial that moves a whole molecule as a rigid body, and test it. Nothing moves until acceptProposal() is
     * called. It is an error if the molecule has fixed particles.
     *
     * @param context      the Context whose positions are the start
     * @param particle     the index of any particle of the molecule
     * @param rotation     the rotation about the centroid of the molecule's particles: a vector along the axis whose
     *                     length is the angle, in radians
     * @param translation  the translation that follows the rotation, in nm
     * @return true if no pair whose distance the trial changes overlaps beyond its limit
     */
    bool proposeRigidMotion(OpenMM::Context& context, int particle, const OpenMM::Vec3& rotation,
                            const OpenMM::Vec3& translation) const;
    /**
     * Get the positions of the proposed trial. It is an error if there is none.
     *
     * @param context         the Context in which the trial was opened
     * @param[out] positions  the positions that acceptProposal() would set, in nm
     */
    void getProposedPositions(OpenMM::Context& context, std::vector<OpenMM::Vec3>& positions) const;
    /**
     * Get the pairs of particles whose distance the proposed trial changes and which are within a cutoff distance of
     * each other before the trial, or in it, or both. A pair energy is updated from these. Excluded pairs and particles
     * of radius 0 are left out, and so may be pairs whose distance changes only by rounding, up to 2e-11 nm, as behind
     * a closed window. It is an error if no trial is proposed. With periodic boundary conditions, distances are those
     * of the nearest images, and the cutoff is at most half the box's width. A distance beyond half the box's width
     * may belong to a farther image.
     *
     * @param context      the Context in which the trial was opened
     * @param cutoff       the cutoff distance, above 0, in nm
     * @param[out] pairs   the pairs, sorted, in each of them the lower index first
     * @param[out] before  the distance of each pair before the trial, in nm
     * @param[out] after   the distance of each pair in the trial, in nm
     */
    void getChangedNeighborPairs(OpenMM::Context& context, double cutoff, std::vector<std::pair<int, int>>& pairs,
                                 std::vector<double>& before, std::vector<double>& after) const;
    /**
     * Move the Context to the proposed positions, even if they clash, and recompute virtual sites. If they clash beyond
     * limits, limits restart from these positions. The velocities of each link rotate with it. It is an error if no
     * trial is proposed, or if turned velocities would break a constraint.
     *
     * @param context  the Context in which the trial was opened
     */
    void acceptProposal(OpenMM::Context& context) const;
    /**
     * End the proposed trial. If there is none, this does nothing.
     *
     * @param context  the Context in which the trial was opened
     */
    void rejectProposal(OpenMM::Context& context) const;
    /**
     * Restart all limits, from the clashes at the next trial or step, as if the user set the present positions.
     *
     * @param context  the Context whose limits restart
     */
    void restartLimits(OpenMM::Context& context) const;
    /**
     * Get the values of all torsions, at the present positions. It is an error if one of them is undefined because
     * three of its particles lie on a straight line.
     *
     * @param context      the Context whose positions are used
     * @param[out] angles  the value of each torsion, in (-pi, pi], in radians
     */
    void getTorsionAngles(OpenMM::Context& context, std::vector<double>& angles) const;
    /**
     * Turn all torsions to given values, even if this makes clashes, and recompute virtual sites. Like setting
     * positions, this restarts limits. It is an error if one of the torsions is undefined because three of its
     * particles lie on a straight line, or if one that lies in the ring of a closure would turn.
     *
     * @param context  the Context to move
     * @param angles   the value of each torsion, in radians
     */
    void setTorsionAngles(OpenMM::Context& context, const std::vector<double>& angles) const;
    /**
     * Get the number of pairs whose limit is not their tolerance, because they clashed when sampling started or after
     * another Integrator moved particles. It is 0 before sampling starts, that is, before the first step or proposal
     * after the Context was created or limits restarted; and after Soft steps of a TorsionMonteCarloIntegrator, which
     * have no limits.
     *
     * @param context  the Context to report on
     */
    int getNumToleratedClashes(OpenMM::Context& context) const;
    /**
     * Get operation counts of the queries and trials of a Context, since it was created or resetTraversalStatistics()
     * was called. Evaluations of energy and forces count as queries, and trials of a TorsionMonteCarloIntegrator too.
     *
     * @param context             the Context to report on
     * @param[out] queries        the number of queries answered and trials tested
     * @param[out] volumeTests    the number of times that two bounding volumes were compared
     * @param[out] particleTests  the number of times that the distance of two particles was computed
     * @param[out] nodesUpdated   the number of tree nodes recomputed for accepted trials
     */
    void getTraversalStatistics(OpenMM::Context& context, long long& queries, long long& volumeTests,
                                long long& particleTests, long long& nodesUpdated) const;
    /**
     * Set the counts of getTraversalStatistics() to 0.
     *
     * @param context  the Context whose counts are reset
     */
    void resetTraversalStatistics(OpenMM::Context& context) const;

protected:
    OpenMM::ForceImpl* createImpl() const;

private:
    friend class StericExclusionForceImpl;
    class Call;
    class ParticleInfo;
    bool hasStructureOf(const StericExclusionForce& other) const;
    std::vector<ParticleInfo> particles;
    std::vector<std::pair<int, int>> bonds;
    std::vector<std::array<int, 4>> torsions;
    std::vector<std::pair<int, int>> ballJoints;
    std::vector<std::array<int, 4>> closures;
    std::vector<std::pair<int, int>> exclusions;
    double overlapTolerance, hydrogenBondAllowance, forceConstant;
    bool usesPeriodic;
};

/**
 * This is an internal class used to record information about a particle.
 * @private
 */
class StericExclusionForce::ParticleInfo {
public:
    double radius;
    HydrogenBondRole role;
};

} // namespace ChainTreePlugin

#endif /*OPENMM_STERICEXCLUSIONFORCE_H_*/
