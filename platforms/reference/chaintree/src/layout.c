/* From a definition to a sequence: the order of links and slots. */
#include <string.h>

#include "order.h"
#include "sequence.h"

/* Scratch of ctSequenceBuild. Vertex 0 is the world, vertex u + 1 the caller's link u; fixed links are part of vertex
 * 0. */
typedef struct Layout {
  int vertexCount;
  int* parent;
  int* slots;      /* of the vertex itself, 0 for fixed links */
  int* filled;     /* slots with particles of the vertex and all below it */
  int* weight;     /* slots of the vertex and all below it */
  int* padding;    /* of a branch of the world: empty slots before it */
  int* childBegin; /* vertexCount + 1 */
  int* children;   /* in sequence order */
  int* breadthFirst;
  int breadthCount;
  int* linkOfVertex;
  int* end;           /* per link: one past the last that hangs on it */
  int* next;          /* per link: a cursor */
  double* rootPoints; /* 3 * vertexCount: where each free root is */
} Layout;

static bool isFixed(const ctDefinition* d, int userLink) {
  return d->linkJoints[userLink] == ctFixedJoint;
}

static int vertexOfLink(const ctDefinition* d, int userLink) {
  return userLink == CT_NULL || isFixed(d, userLink) ? 0 : userLink + 1;
}

/* True if a particle has a slot. */
static bool hasSlot(const ctDefinition* d, int particle) {
  return d->radii[particle] > 0 || (d->listed != NULL && d->listed[particle] != 0);
}

static void countParticles(Layout* layout, const ctDefinition* d) {
  for (int i = 0; i < d->particleCount; i++) {
    if (hasSlot(d, i)) {
      layout->slots[vertexOfLink(d, d->particleLinks[i])]++;
    }
  }
  for (int vertex = 0; vertex < layout->vertexCount; vertex++) {
    layout->filled[vertex] = layout->slots[vertex];
    const bool isPartOfWorld = vertex > 0 && isFixed(d, vertex - 1);
    if (layout->slots[vertex] == 0 && !isPartOfWorld) {
      layout->slots[vertex] = 1;
    }
    layout->weight[vertex] = layout->slots[vertex];
  }
}

static void listChildren(Layout* layout, const ctDefinition* d) {
  for (int u = 0; u < d->linkCount; u++) {
    if (!isFixed(d, u)) {
      layout->parent[u + 1] = vertexOfLink(d, d->linkParents[u]);
      layout->childBegin[layout->parent[u + 1] + 1]++;
    }
  }
  ctAccumulate(layout->childBegin, layout->vertexCount);
  int* next = layout->breadthFirst; /* free until the children are listed */
  memcpy(next, layout->childBegin, (size_t)layout->vertexCount * sizeof(int));
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
    const int vertex = layout->breadthFirst[i];
    for (int c = layout->childBegin[vertex]; c < layout->childBegin[vertex + 1]; c++) {
      layout->breadthFirst[layout->breadthCount++] = layout->children[c];
    }
  }
  for (int i = layout->breadthCount - 1; i > 0; i--) {
    const int vertex = layout->breadthFirst[i];
    layout->weight[layout->parent[vertex]] += layout->weight[vertex];
    layout->filled[layout->parent[vertex]] += layout->filled[vertex];
  }
}

/* Orders free molecules: those without slots first, then the others by position, so that the nodes of the tree are
 * compact. */
static void orderMolecules(Layout* layout, const ctDefinition* d) {
  int* children = layout->children + layout->childBegin[0];
  const int count = layout->childBegin[1] - layout->childBegin[0];
  for (int i = d->particleCount - 1; i >= 0; i--) {
    const int vertex = vertexOfLink(d, d->particleLinks[i]);
    memcpy(layout->rootPoints + 3 * (size_t)vertex, d->positions + 3 * (size_t)i, 3 * sizeof(double));
  }
  int slotless = 0;
  for (int i = 0; i < count; i++) {
    if (layout->filled[children[i]] == 0) {
      const int vertex = children[i];
      memmove(children + slotless + 1, children + slotless, (size_t)(i - slotless) * sizeof(int));
      children[slotless++] = vertex;
    }
  }
  ctSpatialOrder(children + slotless, count - slotless, layout->rootPoints);
}

/* Puts the heaviest branch of each vertex last: its steps need no return frame. */
static void orderChildren(Layout* layout) {
  for (int vertex = 0; vertex < layout->vertexCount; vertex++) {
    int* children = layout->children + layout->childBegin[vertex];
    const int count = layout->childBegin[vertex + 1] - layout->childBegin[vertex];
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

/* True if a branch of the world is a molecule that moves freely and fills half a leaf or more. */
static bool ownsLeaves(const Layout* layout, const ctDefinition* d, int vertex) {
  return d->linkJoints[vertex - 1] == ctFreeJoint && layout->weight[vertex] >= TREE_WIDTH / 2;
}

/* Empty slots before each branch of the world, and thus at the end of the one before it, so that a molecule that owns
 * its leaves shares none with others: such a leaf would reach from one molecule to the other. */
static int padBranches(Layout* layout, const ctDefinition* d) {
  const int64_t width = TREE_WIDTH;
  int64_t slots = layout->slots[0];
  int64_t padding = 0;
  bool ownedBefore = false;
  for (int c = 0; c < layout->childBegin[1]; c++) {
    const int vertex = layout->children[c];
    const bool owns = ownsLeaves(layout, d, vertex);
    /* The first slot alone is that of a world without particles. */
    const bool isShared = ownedBefore || (owns && slots > 1);
    layout->padding[vertex] = isShared ? (int)((width - slots % width) % width) : 0;
    padding += layout->padding[vertex];
    slots += layout->padding[vertex] + layout->weight[vertex];
    ownedBefore = owns;
  }
  return (int)padding;
}

/* Numbers links depth-first, and finds one past the last link that hangs on each. */
static void numberLinks(Layout* layout, Sequence* s, const ctDefinition* d) {
  int* stack = layout->breadthFirst;
  int depth = 0;
  stack[depth++] = 0;
  int link = 0;
  while (depth > 0) {
    const int vertex = stack[--depth];
    layout->linkOfVertex[vertex] = link;
    s->parent[link] = vertex == 0 ? CT_NULL : layout->linkOfVertex[layout->parent[vertex]];
    s->jointType[link] = vertex == 0 ? ctFixedJoint : d->linkJoints[vertex - 1];
    if (s->parent[link] == 0) {
      s->branchHead[s->branchCount++] = link;
    }
    s->slotBegin[link] += layout->padding[vertex];
    s->slotBegin[link + 1] = s->slotBegin[link] + layout->slots[vertex];
    for (int c = layout->childBegin[vertex + 1] - 1; c >= layout->childBegin[vertex]; c--) {
      stack[depth++] = layout->children[c];
    }
    link++;
  }
  for (int l = s->linkCount - 1; l >= 0; l--) {
    layout->end[l] = layout->end[l] > l ? layout->end[l] : l + 1;
    if (l > 0 && layout->end[s->parent[l]] < layout->end[l]) {
      layout->end[s->parent[l]] = layout->end[l];
    }
  }
  for (int u = 0; u < d->linkCount; u++) {
    s->linkOfUser[u] = layout->linkOfVertex[vertexOfLink(d, u)];
  }
}

static void fillSlots(Layout* layout, Sequence* s, const ctDefinition* d) {
  int* next = layout->next;
  memcpy(next, s->slotBegin, (size_t)s->linkCount * sizeof(int));
  for (int link = 0; link < s->linkCount; link++) {
    for (int slot = s->slotBegin[link]; slot < s->slotBegin[link + 1]; slot++) {
      s->slotLink[slot] = link;
      s->slotParticle[slot] = CT_NULL;
    }
  }
  for (int i = 0; i < d->particleCount; i++) {
    if (hasSlot(d, i)) {
      s->slotParticle[next[s->linkOfUser[d->particleLinks[i]]]++] = i;
    }
  }
  for (int link = 0; link < s->linkCount; link++) {
    const int begin = s->slotBegin[link];
    if (next[link] - begin > 1) {
      ctSpatialOrder(s->slotParticle + begin, next[link] - begin, d->positions);
    }
  }
  for (int slot = 0; slot < s->slotCount; slot++) {
    const int particle = s->slotParticle[slot];
    if (particle != CT_NULL) {
      s->slotOrLink[particle] = slot;
    }
  }
}

static void listSlotless(Layout* layout, Sequence* s, const ctDefinition* d) {
  int* next = layout->next;
  memset(next, 0, ((size_t)s->linkCount + 1) * sizeof(int));
  for (int i = 0; i < d->particleCount; i++) {
    if (!hasSlot(d, i)) {
      s->slotOrLink[i] = ~s->linkOfUser[d->particleLinks[i]];
      next[~s->slotOrLink[i] + 1]++;
    }
  }
  ctAccumulate(next, s->linkCount);
  for (int i = 0; i < d->particleCount; i++) {
    if (s->slotOrLink[i] < 0) {
      s->slotlessParticle[next[~s->slotOrLink[i]]++] = i;
    }
  }
}

/* Chooses the origins of links. To be called after slots are filled: from then on linkOfUser of a fixed link holds its
 * lowest particle. */
static void chooseOrigins(Sequence* s, const ctDefinition* d) {
  s->joint[0].origin = CT_NULL;
  for (int i = d->particleCount - 1; i >= 0; i--) {
    const int user = d->particleLinks[i];
    if (isFixed(d, user)) {
      s->linkOfUser[user] = ~i;
    } else {
      s->joint[s->linkOfUser[user]].origin = i;
    }
  }
  for (int u = 0; u < d->linkCount; u++) {
    Joint* joint = &s->joint[sequenceLink(s, u)];
    if (d->linkJoints[u] == ctTorsionJoint) {
      const int* p = d->linkTorsions[u];
      /* A torsion is the same from its other end. */
      const bool thirdMoves = d->particleLinks[p[2]] == u;
      joint->origin = thirdMoves ? p[2] : p[1];
      joint->torsion[0] = thirdMoves ? p[1] : p[2];
      joint->torsion[1] = thirdMoves ? p[0] : p[3];
      joint->torsion[2] = thirdMoves ? p[3] : p[0];
    } else if (d->linkJoints[u] == ctBallJoint) {
      joint->origin = d->linkTorsions[u][1];
    }
  }
  int placements = 0;
  for (int link = 0; link < s->linkCount; link++) {
    if (isPlaced(s, link) && !s->isFlexible) {
      s->joint[link].placement = placements++;
    }
  }
}

static bool allocateSequence(Sequence* s, Arena* arena, const ctDefinition* d, int branches) {
  const size_t links = (size_t)s->linkCount;
  const size_t slots = (size_t)s->slotCount;
  const size_t particles = (size_t)d->particleCount;
  s->linkOfUser = ctArenaAllocate(arena, (size_t)d->linkCount, sizeof(int));
  s->parent = ctArenaAllocate(arena, links, sizeof(int));
  s->jointType = ctArenaAllocate(arena, links, sizeof(uint8_t));
  s->sideBranchPart = ctArenaAllocate(arena, links, sizeof(uint8_t));
  s->joint = ctArenaAllocate(arena, links, sizeof(Joint));
  s->axisPlaces = ctArenaAllocate(arena, links, sizeof(uint8_t));
  s->slotBegin = ctArenaAllocate(arena, links + 1, sizeof(int));
  s->slotLink = ctArenaAllocate(arena, slots, sizeof(int));
  s->slotParticle = ctArenaAllocate(arena, slots, sizeof(int));
  s->slotType = ctArenaAllocate(arena, slots, sizeof(int));
  s->slotOrLink = ctArenaAllocate(arena, particles, sizeof(int));
  s->slotlessParticle = ctArenaAllocate(arena, (size_t)s->slotlessCount, sizeof(int));
  s->pathOf = ctArenaAllocate(arena, links, sizeof(int));
  s->reference = ctArenaAllocate(arena, 3 * (particles + (s->isFlexible ? links : 0)), sizeof(double));
  s->angle = ctArenaAllocate(arena, links, sizeof(double));
  s->rodrigues = ctArenaAllocate(arena, links, sizeof(double));
  s->branchHead = ctArenaAllocate(arena, (size_t)branches, sizeof(int));
  s->displaced = ctArenaAllocate(arena, (size_t)branches, sizeof(int));
  s->wrap = ctArenaAllocate(arena, (size_t)branches, sizeof *s->wrap);
  size_t placements = s->isFlexible ? links : 0;
  for (int u = 0; u < d->linkCount && !s->isFlexible; u++) {
    placements += d->linkJoints[u] == ctFreeJoint || d->linkJoints[u] == ctBallJoint;
  }
  s->placement = ctArenaAllocate(arena, placements, sizeof(Placement));
  return !arena->failed;
}

static bool allocateLayout(Layout* layout, Arena* arena, int vertexCount) {
  const size_t vertices = (size_t)vertexCount;
  layout->vertexCount = vertexCount;
  layout->parent = ctArenaAllocate(arena, vertices, sizeof(int));
  layout->slots = ctArenaAllocate(arena, vertices, sizeof(int));
  layout->filled = ctArenaAllocate(arena, vertices, sizeof(int));
  layout->weight = ctArenaAllocate(arena, vertices, sizeof(int));
  layout->padding = ctArenaAllocate(arena, vertices, sizeof(int));
  layout->childBegin = ctArenaAllocate(arena, vertices + 1, sizeof(int));
  layout->children = ctArenaAllocate(arena, vertices, sizeof(int));
  layout->breadthFirst = ctArenaAllocate(arena, vertices, sizeof(int));
  layout->linkOfVertex = ctArenaAllocate(arena, vertices, sizeof(int));
  layout->end = ctArenaAllocate(arena, vertices, sizeof(int));
  layout->next = ctArenaAllocate(arena, vertices + 1, sizeof(int));
  layout->rootPoints = ctArenaAllocate(arena, 3 * vertices, sizeof(double));
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
  s->isFlexible = d->isFlexible;
  s->particleCount = d->particleCount;
  s->userLinkCount = d->linkCount;
  s->linkCount = layout.breadthCount;
  orderMolecules(&layout, d);
  orderChildren(&layout);
  s->slotCount = layout.weight[0] + padBranches(&layout, d);
  s->slotlessCount = d->particleCount - layout.filled[0];
  bool built = allocateSequence(s, arena, d, layout.childBegin[1]);
  if (built) {
    numberLinks(&layout, s, d);
    fillSlots(&layout, s, d);
    listSlotless(&layout, s, d);
    chooseOrigins(s, d);
    ctSequenceResetTorsions(s);
    built = ctTypesBuild(s, arena, d) && ctPathsBuild(s, arena, layout.end);
  }
  ctArenaFree(&scratch);
  return built;
}
