/* ctTraverse and ctTraverseProbe, compiled once for each instruction set by the file that includes this. */
#include "descent_body.h"
#include "movers_body.h"

static Visit startVisit(Traversal* t, const View* view, CandidateFunction* function, void* context) {
  startView(t, view);
  const double margin = floatMargin(t->extent + fabs(view->reach));
  return (Visit){.function = function, .context = context, .reach = (float)(view->reach + margin), .margin = margin};
}

static int64_t traverse(Traversal* t, const View* view, CandidateFunction* function, void* context, ctCounts* counts) {
  Visit visit = startVisit(t, view, function, context);
  descend(t, &visit);
  addTests(counts, visit.volumeTests, visit.particleTests);
  return visit.volumeTests + visit.particleTests + COST_OF_BOX_TEST * visit.boxTests +
         COST_OF_BOXES * visit.visitsWithBoxes;
}

static void traverseFew(Traversal* t, const View* view, int begin, int end, CandidateFunction* function,
                        ClashFunction* clashes, void* context, ctCounts* counts) {
  Visit visit = startVisit(t, view, function, context);
  visit.clashes = clashes;
  visitFew(t, &visit, begin, end);
  addTests(counts, visit.volumeTests, visit.particleTests);
}

static void traverseProbe(Traversal* t, const View* view, const double point[3], double radius, ProbeFunction* function,
                          void* context, ctCounts* counts) {
  startView(t, view);
  t->motion[treeRoot(t->tree)] = view->pieces[0].body;
  const double size = t->extent + sqrt(dot(point, point)) + radius;
  const float reach = (float)(view->reach + floatMargin(size + fabs(view->reach)));
  const Sphere probe = {(float)point[0], (float)point[1], (float)point[2], (float)radius};
  int depth = 0;
  t->stack[depth++] = (ProbedNode){treeTop(t->tree), treeRoot(t->tree)};
  bool goesOn = true;
  while (goesOn && depth > 0) {
    const ProbedNode probed = t->stack[--depth];
    const int node = probed.node;
    expand(t, probed.level, node);
    unsigned mask = near16(worldOf(t, node), probe, reach);
    if (probed.level > 0) {
      int count;
      const int first = treeChildren(t->tree, probed.level, node, &count);
      for (; mask != 0; mask &= mask - 1) {
        const int child = first + __builtin_ctz(mask);
        t->motion[child] = 0;
        t->stack[depth++] = (ProbedNode){probed.level - 1, child};
      }
      addTests(counts, count, 0);
      continue;
    }
    int end;
    const int begin = treeSlots(t->tree, 0, node, &end);
    for (; goesOn && mask != 0; mask &= mask - 1) {
      const int slot = begin + __builtin_ctz(mask);
      double x[3];
      ctTraversalPosition(t, slot, x);
      goesOn = function(context, slot, squaredDistance(x, point));
    }
    addTests(counts, 0, end - begin);
  }
}
