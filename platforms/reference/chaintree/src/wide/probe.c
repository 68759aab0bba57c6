#include "view.h"

void CT_WIDE(traverseProbe)(Traversal* t, const View* view, const double point[3], double radius,
                            ProbeFunction* function, void* context, ctCounts* counts) {
  CT_WIDE(startView)(t, view);
  t->body[treeRoot(t->tree)] = view->pieces[0].body;
  const double size = t->coordinateBound + sqrt(dot(point, point)) + radius;
  const float reach = (float)(view->reach + floatMargin(size + fabs(view->reach)));
  const Sphere probe = {(float)point[0], (float)point[1], (float)point[2], (float)radius};
  int depth = 0;
  t->stack[depth++] = (ProbedNode){treeTop(t->tree), treeRoot(t->tree)};
  bool continues = true;
  while (continues && depth > 0) {
    const ProbedNode probed = t->stack[--depth];
    const int node = probed.node;
    placeInView(t, probed.level, node);
    unsigned mask = near16(worldOf(t, node), probe, reach);
    if (probed.level > 0) {
      int count;
      const int first = treeChildren(t->tree, probed.level, node, &count);
      for (; mask != 0; mask &= mask - 1) {
        const int child = first + __builtin_ctz(mask);
        t->body[child] = 0;
        t->stack[depth++] = (ProbedNode){probed.level - 1, child};
      }
      addTests(counts, count, 0);
      continue;
    }
    int end;
    const int begin = treeSlots(t->tree, 0, node, &end);
    for (; continues && mask != 0; mask &= mask - 1) {
      const int slot = begin + __builtin_ctz(mask);
      double x[3];
      ctTraversalPosition(t, slot, x);
      continues = function(context, slot, squaredDistance(x, point));
    }
    addTests(counts, 0, end - begin);
  }
}
