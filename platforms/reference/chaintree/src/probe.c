/* Particles that overlap a sphere. */
#include "definition.h"
#include "scene.h"

typedef struct Probe {
  ctChainTree* tree;
  double radius;
  ctParticleFunction* function;
  void* context;
} Probe;

static bool matchProbe(void* context, int none, int slot, double squaredDistance) {
  (void)none;
  const Probe* probe = context;
  const Sequence* s = &probe->tree->sequence;
  const double overlap = slotRadius(s, slot) + probe->radius - sqrt(squaredDistance);
  return overlap <= probe->tree->overlapTolerance || probe->function(probe->context, s->slotParticle[slot], overlap);
}

ctStatus ctForEachClashWith(ctChainTree* tree, const double position[3], double radius, ctParticleFunction* function,
                            void* context, ctCounts* counts) {
  CT_REQUIRE(tree, position);
  if (!areLengths(position)) {
    return ctFail(tree, ctInvalidArgument, "the position of the probe " CT_NO_LENGTH);
  }
  if (!(radius >= 0) || !isLength(radius)) {
    return ctFail(tree, ctInvalidArgument, "the radius of the probe is %g nm; it must be from 0 to 1e15 nm", radius);
  }
  CT_REQUIRE(tree, function);
  double point[3];
  subtract(position, tree->sequence.worldOrigin, point);
  Probe probe = {tree, radius, function, context};
  const View view = ctViewOfState(-tree->overlapTolerance);
  ctSceneLooseTree(tree);
  ctTraverseProbe(&tree->traversal, &view, point, radius, matchProbe, &probe, counts);
  return ctSuccess;
}
