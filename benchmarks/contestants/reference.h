/* Where particles are after turns, in long double: what positions in double are measured by. */
#ifndef REFERENCE_H_
#define REFERENCE_H_

#include "contestant.h"

typedef struct Reference Reference;

/* Whether long double is longer than double on this machine. */
bool referenceIsExact(void);

/* A scene, which must outlive it, as it is; NULL if there is no memory. */
Reference* referenceMake(const Scene* scene);
void referenceFree(Reference* reference);

/* Turns a torsion by an angle, or sets the angles that all have turned. */
void referenceTurn(Reference* reference, const Turn* turn);
void referenceSetAngles(Reference* reference, const double* angles);

/* Writes the positions of all particles. */
void referencePositions(Reference* reference, long double (*positions)[3]);

#endif /* REFERENCE_H_ */
