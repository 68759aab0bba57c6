#include "sequence.h"

#include <float.h>
#include <string.h>

#include "order.h"

/* Links over which a path's product is multiplied one by one: keeps the products few, and side chains to one block. */
enum { PATH_BLOCK = 8 };

/* ---- Layout ---- */

/* Scratch of ctSequenceBuild. Node 0 is the world, node u + 1 the caller's link u; fixed links are part of node 0. */
typedef struct Layout {
  int nodeCount;
  int* parent;
  int* slots;      /* of the node itself, 0 for fixed links */
  int* modelled;   /* modelled particles of the node and all below it */
  int* weight;     /* slots of the node and all below it */
  int* childBegin; /* nodeCount + 1 */
  int* children;   /* in sequence order */
  int* breadthFirst;
  int breadthCount;
  int* linkOfNode;
  double* rootPoints; /* 3 * nodeCount: where each free root is */
} Layout;

static bool isFixed(const ctDefinition* d, int userLink) {
  return d->linkJoints[userLink] == ctFixedJoint;
}

static int nodeOfLink(const ctDefinition* d, int userLink) {
  return userLink == CT_NULL || isFixed(d, userLink) ? 0 : userLink + 1;
}

/* From counts per key in begin[key + 1] to begins. */
static void accumulate(int* begin, int count) {
  for (int i = 0; i < count; i++) {
    begin[i + 1] += begin[i];
  }
}

static void countParticles(Layout* layout, const ctDefinition* d) {
  for (int i = 0; i < d->particleCount; i++) {
    if (d->radii[i] > 0) {
      layout->slots[nodeOfLink(d, d->particleLinks[i])]++;
    }
  }
  for (int node = 0; node < layout->nodeCount; node++) {
    layout->modelled[node] = layout->slots[node];
    const bool isPartOfWorld = node > 0 && isFixed(d, node - 1);
    if (layout->slots[node] == 0 && !isPartOfWorld) {
      layout->slots[node] = 1;
    }
    layout->weight[node] = layout->slots[node];
  }
}

static void listChildren(Layout* layout, const ctDefinition* d) {
  for (int u = 0; u < d->linkCount; u++) {
    if (!isFixed(d, u)) {
      layout->parent[u + 1] = nodeOfLink(d, d->linkParents[u]);
      layout->childBegin[layout->parent[u + 1] + 1]++;
    }
  }
  accumulate(layout->childBegin, layout->nodeCount);
  int* next = layout->breadthFirst; /* free until the children are listed */
  memcpy(next, layout->childBegin, (size_t)layout->nodeCount * sizeof(int));
  for (int u = 0; u < d->linkCount; u++) {
    if (!isFixed(d, u)) {
      layout->children[next[layout->parent[u + 1]]++] = u + 1;
    }
  }
}

static void sumBranches(Layout* layout) {
  layout->breadthFirst[0] = 0;
  layout->breadthCount = 1;
  for (int i = 0; i < layout->breadthCount; i++) {
    const int node = layout->breadthFirst[i];
    for (int c = layout->childBegin[node]; c < layout->childBegin[node + 1]; c++) {
      layout->breadthFirst[layout->breadthCount++] = layout->children[c];
    }
  }
  for (int i = layout->breadthCount - 1; i > 0; i--) {
    const int node = layout->breadthFirst[i];
    layout->weight[layout->parent[node]] += layout->weight[node];
    layout->modelled[layout->parent[node]] += layout->modelled[node];
  }
}

/* Free molecules: first those without modelled particles, then the others by place, so that the tree's nodes are
 * compact. */
static void orderMolecules(Layout* layout, const ctDefinition* d) {
  int* children = layout->children + layout->childBegin[0];
  const int count = layout->childBegin[1] - layout->childBegin[0];
  for (int i = d->particleCount - 1; i >= 0; i--) {
    const int node = nodeOfLink(d, d->particleLinks[i]);
    memcpy(layout->rootPoints + 3 * (size_t)node, d->positions + 3 * (size_t)i, 3 * sizeof(double));
  }
  int idle = 0;
  for (int i = 0; i < count; i++) {
    if (layout->modelled[children[i]] == 0) {
      const int node = children[i];
      memmove(children + idle + 1, children + idle, (size_t)(i - idle) * sizeof(int));
      children[idle++] = node;
    }
  }
  ctSpatialOrder(children + idle, count - idle, layout->rootPoints);
}

/* The heaviest branch goes last: then its steps need no closure. */
static void orderChildren(Layout* layout) {
  for (int node = 0; node < layout->nodeCount; node++) {
    int* children = layout->children + layout->childBegin[node];
    const int count = layout->childBegin[node + 1] - layout->childBegin[node];
    int heaviest = 0;
    for (int i = 1; i < count; i++) {
      if (layout->weight[children[i]] >= layout->weight[children[heaviest]]) {
        heaviest = i;
      }
    }
    if (count > 0) {
      const int child = children[heaviest];
      memmove(children + heaviest, children + heaviest + 1, (size_t)(count - 1 - heaviest) * sizeof(int));
      children[count - 1] = child;
    }
  }
}

/* Depth-first; a link's end follows from its weight in links, counted on the way back. */
static void numberLinks(Layout* layout, Sequence* s, const ctDefinition* d) {
  int* stack = layout->breadthFirst;
  int depth = 0;
  stack[depth++] = 0;
  int link = 0;
  while (depth > 0) {
    const int node = stack[--depth];
    layout->linkOfNode[node] = link;
    s->parent[link] = node == 0 ? CT_NULL : layout->linkOfNode[layout->parent[node]];
    s->joint[link] = node == 0 ? ctFixedJoint : d->linkJoints[node - 1];
    s->branch[link] = node == 0 ? 0 : (s->parent[link] == 0 ? link : s->branch[s->parent[link]]);
    s->slotBegin[link + 1] = s->slotBegin[link] + layout->slots[node];
    if (s->joint[link] == ctTorsionJoint) {
      memcpy(s->torsion[link], d->linkTorsions[node - 1], sizeof s->torsion[link]);
    }
    for (int c = layout->childBegin[node + 1] - 1; c >= layout->childBegin[node]; c--) {
      stack[depth++] = layout->children[c];
    }
    link++;
  }
  for (int l = s->linkCount - 1; l >= 0; l--) {
    s->end[l] = s->end[l] > l ? s->end[l] : l + 1;
    if (l > 0 && s->end[s->parent[l]] < s->end[l]) {
      s->end[s->parent[l]] = s->end[l];
    }
  }
  for (int u = 0; u < d->linkCount; u++) {
    s->linkOfUser[u] = layout->linkOfNode[nodeOfLink(d, u)];
  }
}

static void fillSlots(Sequence* s, const ctDefinition* d) {
  int* next = s->idleBegin; /* used as cursors first */
  memcpy(next, s->slotBegin, ((size_t)s->linkCount + 1) * sizeof(int));
  for (int link = 0; link < s->linkCount; link++) {
    for (int slot = s->slotBegin[link]; slot < s->slotBegin[link + 1]; slot++) {
      s->slotLink[slot] = link;
      s->slotParticle[slot] = CT_NULL;
    }
  }
  for (int i = 0; i < d->particleCount; i++) {
    s->particleLink[i] = s->linkOfUser[d->particleLinks[i]];
    if (d->radii[i] > 0) {
      s->slotParticle[next[s->particleLink[i]]++] = i;
    }
  }
  for (int link = 0; link < s->linkCount; link++) {
    const int begin = s->slotBegin[link];
    if (next[link] - begin > 1) {
      ctSpatialOrder(s->slotParticle + begin, next[link] - begin, d->positions);
    }
  }
  for (int i = 0; i < d->particleCount; i++) {
    s->particleSlot[i] = CT_NULL;
  }
  for (int slot = 0; slot < s->slotCount; slot++) {
    const int particle = s->slotParticle[slot];
    if (particle != CT_NULL) {
      s->particleSlot[particle] = slot;
      s->slotRadius[slot] = d->radii[particle];
      s->slotRole[slot] = d->hydrogenBondRoles == NULL ? ctNoHydrogenBond : d->hydrogenBondRoles[particle];
    }
  }
  memset(s->idleBegin, 0, ((size_t)s->linkCount + 1) * sizeof(int));
  for (int i = 0; i < d->particleCount; i++) {
    s->idleBegin[s->particleLink[i] + 1] += s->particleSlot[i] == CT_NULL;
  }
  accumulate(s->idleBegin, s->linkCount);
  int* cursor = s->displaced; /* free until there is a state */
  memcpy(cursor, s->idleBegin, (size_t)s->linkCount * sizeof(int));
  for (int i = 0; i < d->particleCount; i++) {
    if (s->particleSlot[i] == CT_NULL) {
      s->idleParticle[cursor[s->particleLink[i]]++] = i;
    }
  }
}

static void chooseOrigins(Sequence* s, const ctDefinition* d) {
  for (int u = 0; u < d->linkCount; u++) {
    s->originOfUser[u] = CT_NULL;
  }
  for (int i = d->particleCount - 1; i >= 0; i--) {
    s->originOfUser[d->particleLinks[i]] = i;
  }
  s->originParticle[0] = CT_NULL;
  for (int u = 0; u < d->linkCount; u++) {
    const int link = s->linkOfUser[u];
    if (d->linkJoints[u] == ctTorsionJoint) {
      const int second = d->linkTorsions[u][1];
      const int third = d->linkTorsions[u][2];
      const bool thirdMoves = d->particleLinks[third] == u;
      s->originOfUser[u] = thirdMoves ? third : second;
      s->axisParticle[link] = thirdMoves ? second : third;
    }
    if (link > 0) {
      s->originParticle[link] = s->originOfUser[u];
    }
  }
}

/* ---- Paths ---- */

static int blockCount(const Sequence* s, int path) {
  return (s->pathBegin[path + 1] - s->pathBegin[path] + PATH_BLOCK - 1) / PATH_BLOCK;
}

/* Products of `blocks` blocks: the blocks, then half as many pairs, down to one. */
static int productCount(int blocks) {
  int count = blocks;
  for (int n = blocks; n > 1; n = (n + 1) / 2) {
    count += (n + 1) / 2;
  }
  return count;
}

/* The last link that hangs on the parent heads no path of its own. */
static bool headsPath(const Sequence* s, int link) {
  return link > 0 && s->end[link] != s->end[s->parent[link]];
}

static bool buildPaths(Sequence* s, Arena* arena) {
  s->pathOf[0] = CT_NULL;
  for (int link = 1; link < s->linkCount; link++) {
    const int parent = s->parent[link];
    s->pathOf[link] = headsPath(s, link) ? s->pathCount++ : s->pathOf[parent];
    s->pathPosition[link] = headsPath(s, link) ? 0 : s->pathPosition[parent] + 1;
  }
  s->pathBegin = ctArenaAllocate(arena, (size_t)s->pathCount + 1, sizeof(int));
  s->productBegin = ctArenaAllocate(arena, (size_t)s->pathCount + 1, sizeof(int));
  s->pathLink = ctArenaAllocate(arena, (size_t)s->linkCount, sizeof(int));
  s->closure = ctArenaAllocate(arena, (size_t)s->pathCount, sizeof(ctTransform));
  if (arena->failed) {
    return false;
  }
  for (int link = 1; link < s->linkCount; link++) {
    if (s->pathOf[link] != CT_NULL) {
      s->pathBegin[s->pathOf[link] + 1]++;
    }
  }
  accumulate(s->pathBegin, s->pathCount);
  for (int link = 1; link < s->linkCount; link++) {
    if (s->pathOf[link] != CT_NULL) {
      s->pathLink[s->pathBegin[s->pathOf[link]] + s->pathPosition[link]] = link;
    }
  }
  for (int path = 0; path < s->pathCount; path++) {
    s->productBegin[path + 1] = s->productBegin[path] + productCount(blockCount(s, path));
  }
  s->product = ctArenaAllocate(arena, (size_t)s->productBegin[s->pathCount], sizeof(ctTransform));
  return !arena->failed;
}

static void multiplyBlock(Sequence* s, int path, int block) {
  const int begin = s->pathBegin[path] + block * PATH_BLOCK;
  const int end = begin + PATH_BLOCK < s->pathBegin[path + 1] ? begin + PATH_BLOCK : s->pathBegin[path + 1];
  ctTransform product = ctSequenceOpening(s, s->pathLink[begin]);
  for (int i = begin + 1; i < end; i++) {
    const ctTransform opening = ctSequenceOpening(s, s->pathLink[i]);
    product = transformCompose(&product, &opening);
  }
  s->product[s->productBegin[path] + block] = product;
}

/* Recomputes these blocks (ascending) of a path and all products over them, each once; returns how many. */
static int multiplyPath(Sequence* s, int path, int* blocks, int count) {
  for (int i = 0; i < count; i++) {
    multiplyBlock(s, path, blocks[i]);
  }
  int multiplied = count;
  ctTransform* below = s->product + s->productBegin[path];
  for (int n = blockCount(s, path); n > 1; n = (n + 1) / 2) {
    ctTransform* above = below + n;
    int kept = 0;
    for (int i = 0; i < count; i++) {
      const int pair = blocks[i] / 2;
      if (kept == 0 || blocks[kept - 1] != pair) {
        blocks[kept++] = pair;
        above[pair] = 2 * pair + 1 < n ? transformCompose(&below[2 * pair], &below[2 * pair + 1]) : below[2 * pair];
      }
    }
    count = kept;
    multiplied += kept;
    below = above;
  }
  s->closure[path] = transformInverse(below);
  return multiplied;
}

/* ---- Public to the engine ---- */

static bool allocateSequence(Sequence* s, Arena* arena, const ctDefinition* d, int slotCount) {
  const size_t links = (size_t)s->linkCount;
  const size_t slots = (size_t)slotCount;
  const size_t particles = (size_t)d->particleCount;
  s->linkOfUser = ctArenaAllocate(arena, (size_t)d->linkCount, sizeof(int));
  s->originOfUser = ctArenaAllocate(arena, (size_t)d->linkCount, sizeof(int));
  s->parent = ctArenaAllocate(arena, links, sizeof(int));
  s->end = ctArenaAllocate(arena, links, sizeof(int));
  s->joint = ctArenaAllocate(arena, links, sizeof(uint8_t));
  s->originParticle = ctArenaAllocate(arena, links, sizeof(int));
  s->axisParticle = ctArenaAllocate(arena, links, sizeof(int));
  s->torsion = ctArenaAllocate(arena, links, sizeof(int[4]));
  s->branch = ctArenaAllocate(arena, links, sizeof(int));
  s->placementOf = ctArenaAllocate(arena, links, sizeof(int));
  s->slotBegin = ctArenaAllocate(arena, links + 1, sizeof(int));
  s->slotLink = ctArenaAllocate(arena, slots, sizeof(int));
  s->slotParticle = ctArenaAllocate(arena, slots, sizeof(int));
  s->slotRadius = ctArenaAllocate(arena, slots, sizeof(double));
  s->slotRole = ctArenaAllocate(arena, slots, sizeof(uint8_t));
  s->particleLink = ctArenaAllocate(arena, particles, sizeof(int));
  s->particleSlot = ctArenaAllocate(arena, particles, sizeof(int));
  s->idleBegin = ctArenaAllocate(arena, links + 1, sizeof(int));
  s->idleParticle = ctArenaAllocate(arena, particles, sizeof(int));
  s->pathOf = ctArenaAllocate(arena, links, sizeof(int));
  s->pathPosition = ctArenaAllocate(arena, links, sizeof(int));
  s->reference = ctArenaAllocate(arena, 3 * particles, sizeof(double));
  s->angle = ctArenaAllocate(arena, links, sizeof(double));
  s->cosine = ctArenaAllocate(arena, links, sizeof(double));
  s->sine = ctArenaAllocate(arena, links, sizeof(double));
  s->displaced = ctArenaAllocate(arena, links, sizeof(int));
  s->origin = ctArenaAllocate(arena, links, sizeof(double[3]));
  s->axis = ctArenaAllocate(arena, links, sizeof(double[3]));
  int placements = 0;
  for (int u = 0; u < d->linkCount; u++) {
    placements += d->linkJoints[u] == ctFreeJoint;
  }
  s->placement = ctArenaAllocate(arena, (size_t)placements, sizeof(Placement));
  return !arena->failed;
}

static bool allocateLayout(Layout* layout, Arena* arena, int nodeCount) {
  const size_t nodes = (size_t)nodeCount;
  layout->nodeCount = nodeCount;
  layout->parent = ctArenaAllocate(arena, nodes, sizeof(int));
  layout->slots = ctArenaAllocate(arena, nodes, sizeof(int));
  layout->modelled = ctArenaAllocate(arena, nodes, sizeof(int));
  layout->weight = ctArenaAllocate(arena, nodes, sizeof(int));
  layout->childBegin = ctArenaAllocate(arena, nodes + 1, sizeof(int));
  layout->children = ctArenaAllocate(arena, nodes, sizeof(int));
  layout->breadthFirst = ctArenaAllocate(arena, nodes, sizeof(int));
  layout->linkOfNode = ctArenaAllocate(arena, nodes, sizeof(int));
  layout->rootPoints = ctArenaAllocate(arena, 3 * nodes, sizeof(double));
  return !arena->failed;
}

bool ctSequenceBuild(Sequence* s, Arena* arena, const ctDefinition* d) {
  Arena scratch = {0};
  Layout layout = {0};
  if (!allocateLayout(&layout, &scratch, d->linkCount + 1)) {
    ctArenaFree(&scratch);
    return false;
  }
  countParticles(&layout, d);
  listChildren(&layout, d);
  sumBranches(&layout);
  s->particleCount = d->particleCount;
  s->userLinkCount = d->linkCount;
  s->linkCount = layout.breadthCount;
  s->slotCount = layout.weight[0];
  const bool allocated = allocateSequence(s, arena, d, s->slotCount);
  if (allocated) {
    orderMolecules(&layout, d);
    orderChildren(&layout);
    numberLinks(&layout, s, d);
    fillSlots(s, d);
    chooseOrigins(s, d);
    int placements = 0;
    for (int link = 0; link < s->linkCount; link++) {
      s->placementOf[link] = s->joint[link] == ctFreeJoint ? placements++ : CT_NULL;
    }
  }
  ctArenaFree(&scratch);
  return allocated && buildPaths(s, arena);
}

static void findOrigin(Sequence* s) {
  double low[3] = {DBL_MAX, DBL_MAX, DBL_MAX};
  double high[3] = {-DBL_MAX, -DBL_MAX, -DBL_MAX};
  for (int i = 0; i < s->particleCount; i++) {
    for (int k = 0; k < 3; k++) {
      const double x = s->reference[3 * (size_t)i + (size_t)k];
      low[k] = x < low[k] ? x : low[k];
      high[k] = x > high[k] ? x : high[k];
    }
  }
  for (int k = 0; k < 3; k++) {
    s->worldOrigin[k] = s->particleCount > 0 ? 0.5 * low[k] + 0.5 * high[k] : 0;
  }
}

static const JointState REFERENCE_JOINT = {0, 1, 0, {{1, 0, 0, 0}, {0, 0, 0}}};

/* Where the link's origin is in its parent's frame in the reference positions. */
static void referenceOffset(const Sequence* s, int link, double offset[3]) {
  subtract(s->origin[link], s->origin[s->parent[link]], offset);
}

void ctSequenceSetReference(Sequence* s, const double* positions) {
  memcpy(s->reference, positions, 3 * (size_t)s->particleCount * sizeof(double));
  findOrigin(s);
  for (int link = 1; link < s->linkCount; link++) {
    const double* origin = s->reference + 3 * (size_t)s->originParticle[link];
    subtract(origin, s->worldOrigin, s->origin[link]);
    JointState joint = REFERENCE_JOINT;
    if (s->joint[link] == ctTorsionJoint) {
      double* axis = s->axis[link];
      subtract(origin, s->reference + 3 * (size_t)s->axisParticle[link], axis);
      const double length = sqrt(dot(axis, axis));
      for (int k = 0; k < 3; k++) {
        axis[k] = length > 0 ? axis[k] / length : 0;
      }
    } else {
      referenceOffset(s, link, joint.placement.position);
    }
    s->angle[link] = joint.angle;
    s->cosine[link] = joint.cosine;
    s->sine[link] = joint.sine;
    if (s->placementOf[link] != CT_NULL) {
      s->placement[s->placementOf[link]] = joint.placement;
    }
  }
  memset(s->displaced, 0, (size_t)s->linkCount * sizeof(int));
  ctSequenceMultiply(s);
}

void ctSequenceMultiply(Sequence* s) {
  for (int path = 0; path < s->pathCount; path++) {
    for (int block = 0; block < blockCount(s, path); block++) {
      multiplyPath(s, path, &(int){block}, 1);
    }
  }
}

ctTransform ctSequenceOpening(const Sequence* s, int link) {
  ctTransform opening;
  if (s->joint[link] == ctTorsionJoint) {
    rotationAbout(s->axis[link], s->cosine[link], s->sine[link], opening.rotation);
    referenceOffset(s, link, opening.translation);
  } else {
    const Placement* placement = &s->placement[s->placementOf[link]];
    rotationFromQuaternion(placement->quaternion, opening.rotation);
    memcpy(opening.translation, placement->position, sizeof opening.translation);
  }
  return opening;
}

ctTransform ctSequenceStep(const Sequence* s, int link) {
  const ctTransform opening = ctSequenceOpening(s, link + 1);
  if (s->parent[link + 1] == link) {
    return opening;
  }
  return transformCompose(&s->closure[s->pathOf[link]], &opening);
}

JointState ctSequenceGetJoint(const Sequence* s, int link) {
  JointState joint = REFERENCE_JOINT;
  joint.angle = s->angle[link];
  joint.cosine = s->cosine[link];
  joint.sine = s->sine[link];
  if (s->placementOf[link] != CT_NULL) {
    joint.placement = s->placement[s->placementOf[link]];
  }
  return joint;
}

JointState ctJointTurned(const JointState* joint, double angle) {
  const double twoPi = 6.283185307179586476925286766559;
  JointState turned = *joint;
  turned.angle = remainder(joint->angle + remainder(angle, twoPi), twoPi);
  turned.cosine = cos(turned.angle);
  turned.sine = sin(turned.angle);
  return turned;
}

JointState ctJointMoved(const JointState* joint, const double rotation[3], const double pivot[3],
                        const double shift[3]) {
  JointState moved = *joint;
  double turn[4];
  ctTransform motion;
  quaternionFromVector(rotation, turn);
  rotationFromQuaternion(turn, motion.rotation);
  double arm[3];
  subtract(joint->placement.position, pivot, arm);
  rotate(motion.rotation, arm, arm);
  for (int k = 0; k < 3; k++) {
    moved.placement.position[k] = pivot[k] + arm[k] + shift[k];
  }
  quaternionMultiply(turn, joint->placement.quaternion, moved.placement.quaternion);
  return moved;
}

static bool isDisplaced(const Sequence* s, int link) {
  if (s->joint[link] == ctTorsionJoint) {
    return s->angle[link] != 0;
  }
  double offset[3];
  referenceOffset(s, link, offset);
  const Placement* placement = &s->placement[s->placementOf[link]];
  const double* q = placement->quaternion;
  const double* position = placement->position;
  return q[0] != 1 || q[1] != 0 || q[2] != 0 || q[3] != 0 || position[0] != offset[0] || position[1] != offset[1] ||
         position[2] != offset[2];
}

void ctSequenceSetJoint(Sequence* s, int link, const JointState* joint) {
  s->displaced[s->branch[link]] -= isDisplaced(s, link);
  s->angle[link] = joint->angle;
  s->cosine[link] = joint->cosine;
  s->sine[link] = joint->sine;
  if (s->placementOf[link] != CT_NULL) {
    s->placement[s->placementOf[link]] = joint->placement;
  }
  s->displaced[s->branch[link]] += isDisplaced(s, link);
}

int ctSequenceUpdate(Sequence* s, const int* links, int count, int* scratch) {
  /* By path, and in it by position: links of one path ascend with their positions, so sorting by path is enough, and a
   * stable order comes from sorting indices into pathLink. */
  int touched = 0;
  for (int i = 0; i < count; i++) {
    if (s->pathOf[links[i]] != CT_NULL) {
      scratch[touched++] = s->pathBegin[s->pathOf[links[i]]] + s->pathPosition[links[i]];
    }
  }
  ctSortInts(scratch, touched);
  int multiplied = 0;
  int begin = 0;
  while (begin < touched) {
    const int path = s->pathOf[s->pathLink[scratch[begin]]];
    int blocks = 0;
    int i = begin;
    for (; i < touched && scratch[i] < s->pathBegin[path + 1]; i++) {
      const int block = (scratch[i] - s->pathBegin[path]) / PATH_BLOCK;
      if (blocks == 0 || scratch[begin + blocks - 1] != block) {
        scratch[begin + blocks++] = block;
      }
    }
    multiplied += multiplyPath(s, path, scratch + begin, blocks);
    begin = i;
  }
  return multiplied;
}
