/* Molecules: links that a scene in a periodic box shifts together by box vectors. */
#ifndef CT_MOLECULES_H_
#define CT_MOLECULES_H_

#include "ctenergy.h"

/* The molecule of each of the caller's links: 0 if it is not shifted, else the number after that of its root,
 * a link with a free joint on the world. NULL if there is no memory. O(links). */
int* ctFindMolecules(const ctDefinition* scene);

#endif /* CT_MOLECULES_H_ */
