/* Particles that overlap a sphere. */
#include "definition.h"
#include "scene.h"
#include "volume.h"

typedef struct Probe {
  ctChainTree* tree;
  double radius;
  ctParticleFunction* function;
  void* context;
  bool isOver; /* `function` has returned false */
} Probe;

static bool matchProbe(void* context, int none, int slot, double squaredDistance) {
  (void)none;
  Probe* probe = context;
  const Sequence* s = &probe->tree->sequence;
  const double overlap = slotRadius(s, slot) + probe->radius - sqrt(squaredDistance);
  probe->isOver =
      overlap > probe->tree->overlapTolerance && !probe->function(probe->context, s->slotParticle[slot], overlap);
  return !probe->isOver;
}

static void probeAt(Probe* probe, const double point[3], ctCounts* counts) {
  ctChainTree* tree = probe->tree;
  const View view = ctViewOfState(-tree->overlapTolerance);
  ctSceneLooseTree(tree);
  ctTraverseProbe(&tree->traversal, &view, point, probe->radius, matchProbe, probe, counts);
}

/* Probes at the images of a point that are near the box around all particles. */
static void probeImages(Probe* probe, const double point[3], ctCounts* counts) {
  const Tree* tree = ctSceneLooseTree(probe->tree);
  const Bound* bound = &tree->bound[treeRoot(tree)];
  const double centre[3] = {bound->x, bound->y, bound->z};
  const double reach = (double)bound->r + probe->radius;
  const double size = sqrt(dot(centre, centre)) + sqrt(dot(point, point)) + reach;
  ImageRange range = ctImageRange(&probe->tree->sequence.box, point, point, centre, centre, reach + floatMargin(size));
  while (!probe->isOver && ctNextImage(&range)) {
    double image[3];
    for (int d = 0; d < 3; d++) {
      image[d] = point[d] + range.image.shift[d];
    }
    probeAt(probe, image, counts);
  }
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
  const double width = ctBoxWidth(&tree->sequence.box);
  const double reach = radius + ctLargestRadius(&tree->sequence) - tree->overlapTolerance;
  if (tree->sequence.box.isPeriodic && 2 * reach > width) {
    return ctFail(tree, ctInvalidArgument,
                  "the probe of radius %g nm clashes up to %g nm away; that must be at most half the periodic box's "
                  "width, %g nm",
                  radius, reach, width / 2);
  }
  double point[3];
  subtract(position, tree->sequence.worldOrigin, point);
  Probe probe = {tree, radius, function, context, false};
  probeAt(&probe, point, counts);
  if (tree->sequence.box.isPeriodic) {
    probeImages(&probe, point, counts);
  }
  return ctSuccess;
}
