/* Oriented boxes of nodes in a view. */
#ifndef CT_VIEWBOXES_H_
#define CT_VIEWBOXES_H_

#include "view.h"

/* The boxes of the children of an expanded node, in the view. They stay for the visit: see BOXES_OF_A_VISIT. */
const BoxBlock* CT_WIDE(boxesInView)(Traversal* t, int level, int node);

#endif /* CT_VIEWBOXES_H_ */
