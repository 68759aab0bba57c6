/* Turns that stop where the moving particles come to touch the others, and how far these then overlap, in long double.
 */
#ifndef CONTACTS_H_
#define CONTACTS_H_

#include "contestant.h"
#include "errors.h"
#include "random.h"

typedef struct ParticlePair {
  int resting;
  int moving;
} ParticlePair;

/* A turn from a state without clashes to where particles touch. */
typedef struct Contact {
  int torsion;
  double angle;
  int pairCount;
  int capacity;
  ParticlePair* pairs; /* those that are about to touch there; the first is the one that does */
} Contact;

typedef enum ContactStatus { contactFound, contactNone, contactNoMemory } ContactStatus;

/* Looks for one by chance in a state, where particles are at `places`. `judge` is a contestant in that state, who finds
 * about where particles touch. None is found if no turn that was tried makes a clash, or all go past too gently to tell
 * where. The contact is freed by contactFree, whatever comes back. */
ContactStatus contactFind(const Scene* scene, const Place* places, const Contestant* judge, void* self, Random* random,
                          Contact* contact);
void contactFree(Contact* contact);

/* About the angle at which the overlap is as wanted, nm; false if that is too far from the contact. */
bool contactAngle(const Scene* scene, const Place* places, const Contact* contact, double overlap, double* angle);

/* The largest overlap of particles that the turn moves relative to each other, at an angle from contactAngle. */
long double contactOverlap(const Scene* scene, const Place* places, const Contact* contact, double angle);

#endif /* CONTACTS_H_ */
