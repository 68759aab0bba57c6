/* Oriented boxes of nodes in a view. */
#ifndef CT_VIEWBOXES_H_
#define CT_VIEWBOXES_H_

#include "view.h"

/* Boxes of the children of a placed node, in the view. They stay valid for the visit: see BOXES_PER_VISIT. */
const BoxBlock* CT_WIDE(boxesInView)(Traversal* t, int level, int node);

#endif /* CT_VIEWBOXES_H_ */
