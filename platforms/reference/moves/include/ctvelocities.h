/* ctvelocities.h: velocities of particles whose rigid bodies were turned.
 *
 * A move that turns bodies from one configuration to another turns the velocities of each body with it, v' = R v.
 * This keeps the lengths of velocities, and with them the kinetic energy, and keeps relative velocities along a line
 * within a body, or along the axis about which two bodies turn. Given the two configurations the map of velocities is
 * orthogonal, and the map of the reverse move is its inverse: it keeps volume, and a Maxwell distribution.
 *
 * Rotations are row-major. No call allocates memory. Everything is a pure function of its arguments. With a pointer
 * that is NULL, or without bodies or particles (a count of 0 or less), a call does nothing and returns false. A
 * particle's body has to be an index into the turns, which no call can check.
 */
#ifndef CT_VELOCITIES_H_
#define CT_VELOCITIES_H_

#include <stdbool.h>

#ifdef __cplusplus
extern "C" {
#endif

/* Makes orientations of `count` bodies after a move the turns from those before it, after before^T. A body whose
 * orientation has the same bits is not turned: its turn is the identity. False if that holds for all. */
bool ctFindTurns(int count, const double (*before)[9], double (*after)[9]);

/* Turns the velocities (3 * particleCount numbers) of all particles, each with its body: v' = R v. O(particleCount). */
void ctTurnVelocities(int particleCount, const int* particleBodies, const double (*turns)[9], double* velocities);

/* The same, and keeps the momentum P, for systems whose momentum is removed elsewhere. With w = v -
 * P/M, Q the turn of the body of the heaviest particle, <> the mean over mass and y the solution of (1 + <R Q^T>) y =
 * <R w>,
 *
 *     v' = P/M + R w - (1 + R Q^T) y.
 *
 * This is R followed by a rotation, orthogonal with masses as weights, in the space of shifts of all particles and of
 * shifts of bodies turned by R. It keeps kinetic energy and is undone by the move back, as R alone is. A particle of
 * mass 0 is merely turned, as all are if no particle has a mass. */
void ctTurnVelocitiesKeepingMomentum(int particleCount, const int* particleBodies, const double (*turns)[9],
                                     const double* masses, double* velocities);

/* Rotates velocities by the least rotation, orthogonal with masses as weights, that takes the direction of `from` to
 * the direction of `to`; both are 3 * particleCount numbers, as velocities are. It keeps kinetic energy, and is undone
 * by the rotation from `to` to `from`. Where one of them is 0, or they are opposite within rounding, velocities stay.
 *
 * Leapfrog integrators keep velocities of half a step before the positions, which lack half a step of the forces there.
 * Velocities that are turned to other positions should lack the forces at these instead. With `from` the accelerations
 * at the former positions, turned with the velocities, and `to` the accelerations at the new ones, they do, except for
 * the difference in length. */
void ctRotateVelocities(int particleCount, const double* masses, const double* from, const double* to,
                        double* velocities);

#ifdef __cplusplus
}
#endif

#endif /* CT_VELOCITIES_H_ */
