/* Pairs of leaves with periodic images. */
#ifndef CT_LEAFIMAGES_H_
#define CT_LEAFIMAGES_H_

#include "set.h"

/* Gives the members of a node their boxes and bodies in the trial; its parent must have them. In the state there is
 * nothing to do. */
void CT_WIDE(openMembers)(const LeafTask* task, int level, int node);

/* Adds the pairs of leaves with images. The super-root must be open. */
void CT_WIDE(listLeafImages)(LeafTask* task);

#endif /* CT_LEAFIMAGES_H_ */
