#include "view.h"

/* The sphere of a slot of this body in the view. */
static Sphere slotSphere(Traversal* t, int slot, int body) {
  const int leaf = coveringNode(slot);
  const Revision since = t->world->builtFrom[leaf];
  if (t->tree->contentRevision[leaf] > since) {
    CT_WIDE(updateWorldAt)(t->world, 0, leaf);
  } else if (movedSince(&t->tree->changes, since)) {
    if (nodeMovedSince(t->tree, 0, leaf, since)) {
      CT_WIDE(updateWorldAt)(t->world, 0, leaf);
    } else {
      confirmWorld(t->world, leaf);
    }
  }
  return sphereInView(t, sphereOf(worldOf(t->world, leaf), memberIndex(slot)), body);
}

/* True if a recent clash clashes again, as `function` decides. Adds the cost. */
bool CT_WIDE(testRecentClashes)(const RecentClashes* w, Traversal* t, const View* view, CandidateFunction* function,
                                void* context, ctCounts* counts, int64_t* cost) {
  CT_WIDE(startView)(t, view);
  const float viewReach = (float)(view->reach + floatMargin(t->coordinateBound + fabs(view->reach)));
  *cost += COST_OF_RECENT_CLASHES + COST_OF_RECENT_CLASH * w->count;
  int particleTests = 0;
  bool isOver = false;
  for (int i = 0; i < w->count && !isOver; i++) {
    const int* pair = w->pair[i];
    const int bodyA = bodyOfSlot(view, pair[0]);
    const int bodyB = bodyOfSlot(view, pair[1]);
    const Image* image = isImage(&w->image[i]) ? &w->image[i] : NULL;
    if (bodyA == bodyB && (image == NULL || keepsDirection(view, bodyA))) {
      continue;
    }
    *cost += COST_OF_RECENT_CLASH_TEST;
    particleTests++;
    const float shift[3] = {(float)w->image[i].shift[0], (float)w->image[i].shift[1], (float)w->image[i].shift[2]};
    const Sphere a = shifted(slotSphere(t, pair[0], bodyA), shift, 1);
    const Sphere b = slotSphere(t, pair[1], bodyB);
    const float reach = a.r + b.r + (image == NULL ? viewReach : (float)(view->reach + imageMargin(t, image->shift)));
    if ((a.x - b.x) * (a.x - b.x) + (a.y - b.y) * (a.y - b.y) + (a.z - b.z) * (a.z - b.z) >= reach * reach) {
      continue;
    }
    double x[3];
    double y[3];
    ctPositionInView(t, pair[0], bodyA, x);
    ctPositionInView(t, pair[1], bodyB, y);
    t->image = image;
    isOver =
        !function(context, pair[0], pair[1], image == NULL ? squaredDistance(x, y) : squaredImageDistance(x, y, image));
  }
  t->image = NULL;
  addTests(counts, 0, particleTests);
  return isOver;
}
