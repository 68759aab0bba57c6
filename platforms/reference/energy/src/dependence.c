#include "dependence.h"

#include <stdlib.h>

/* ---- The forest of links ---- */

/* A particle of a measure, and the vertex up to which it has been followed. */
typedef struct Climber {
  int particle; /* CT_NULL: the world */
  int vertex;
} Climber;

/* Vertex 0 is the world with all fixed links, vertex u + 1 the caller's link u. */
typedef struct Forest {
  const ctDefinition* scene;
  int* depth;        /* of each vertex; of the world 0 */
  int* measured;     /* scratch for the particles of a measure */
  Climber* climbers; /* the same */
} Forest;

static int vertexOf(const ctDefinition* scene, int link) {
  return link == CT_NULL || scene->linkJoints[link] == ctFixedJoint ? 0 : link + 1;
}

static int parentOf(const ctDefinition* scene, int vertex) {
  return vertexOf(scene, scene->linkParents[vertex - 1]);
}

static void freeForest(Forest* forest) {
  free(forest->depth);
  free(forest->measured);
  free(forest->climbers);
}

/* Each vertex gets its depth once, from the nearest ancestor that has one. `most` particles are in a measure. */
static bool makeForest(const ctDefinition* scene, size_t most, Forest* forest) {
  *forest = (Forest){.scene = scene,
                     .depth = calloc((size_t)scene->linkCount + 1, sizeof(int)),
                     .measured = malloc((most + 1) * sizeof(int)),
                     .climbers = malloc((most + 1) * sizeof(Climber))};
  if (forest->depth == NULL || forest->measured == NULL || forest->climbers == NULL) {
    return false;
  }
  for (int link = 0; link < scene->linkCount; link++) {
    int steps = 0;
    int vertex = vertexOf(scene, link);
    for (; vertex != 0 && forest->depth[vertex] == 0; vertex = parentOf(scene, vertex)) {
      steps++;
    }
    int depth = forest->depth[vertex] + steps;
    for (vertex = vertexOf(scene, link); vertex != 0 && forest->depth[vertex] == 0; vertex = parentOf(scene, vertex)) {
      forest->depth[vertex] = depth--;
    }
  }
  return true;
}

/* True if the joint of a vertex turns about an axis through a particle, or about the particle itself, which therefore
 * keeps its place relative to both sides. */
static bool isOnAxis(const ctDefinition* scene, int vertex, int particle) {
  const int link = vertex - 1;
  switch (scene->linkJoints[link]) {
    case ctTorsionJoint:
      return particle == scene->linkTorsions[link][1] || particle == scene->linkTorsions[link][2];
    case ctBallJoint:
      return particle == scene->linkTorsions[link][1];
    default:
      return false;
  }
}

/* ---- The joints that change a term ---- */

/* A term with more joints is wide. */
enum { MOST_JOINTS = 8 };

typedef struct JointList {
  int count; /* MOST_JOINTS + 1: more than the list holds */
  int links[MOST_JOINTS + 1];
} JointList;

static void addJoint(JointList* joints, int link) {
  for (int i = 0; i < joints->count; i++) {
    if (joints->links[i] == link) {
      return;
    }
  }
  joints->links[joints->count++] = link;
}

/* The deepest vertex of `count` climbers, or CT_NULL if all are at one. */
static int deepestVertex(const Forest* forest, int count) {
  const Climber* climbers = forest->climbers;
  int deepest = climbers[0].vertex;
  bool areTogether = true;
  for (int i = 1; i < count; i++) {
    areTogether &= climbers[i].vertex == climbers[0].vertex;
    deepest = forest->depth[climbers[i].vertex] > forest->depth[deepest] ? climbers[i].vertex : deepest;
  }
  return areTogether ? CT_NULL : deepest;
}

/* Adds the joints that change a measure of `count` climbers: joints with particles off their axis on both sides.
 * From the deepest vertex upwards, the joint of a vertex moves just the particles there. */
static void addJointsOfMeasure(const Forest* forest, int count, JointList* joints) {
  for (int vertex = deepestVertex(forest, count); vertex != CT_NULL && joints->count <= MOST_JOINTS;
       vertex = deepestVertex(forest, count)) {
    bool movesSome = false;
    bool leavesSome = false;
    for (int i = 0; i < count; i++) {
      Climber* climber = &forest->climbers[i];
      const bool isMoved = climber->vertex == vertex;
      if (!isOnAxis(forest->scene, vertex, climber->particle)) {
        movesSome |= isMoved;
        leavesSome |= !isMoved;
      }
      if (isMoved) {
        climber->vertex = parentOf(forest->scene, vertex);
      }
    }
    if (movesSome && leavesSome) {
      addJoint(joints, vertex - 1);
    }
  }
}

/* The joints that change a term of these particles. */
static JointList jointsOf(const Forest* forest, const ctTermSet* set, int term) {
  JointList joints = {0};
  const int* particles = set->particles + (size_t)term * (size_t)set->particlesPerTerm;
  int count;
  for (int measure = 0; (count = ctMeasuredParticles(set, measure, forest->measured)) > 0; measure++) {
    for (int i = 0; i < count; i++) {
      const int particle = particles[forest->measured[i]];
      forest->climbers[i] = (Climber){particle, vertexOf(forest->scene, forest->scene->particleLinks[particle])};
    }
    if (ctMeasuresPlace(set, measure)) {
      forest->climbers[count++] = (Climber){CT_NULL, 0};
    }
    addJointsOfMeasure(forest, count, &joints);
  }
  return joints;
}

/* True if a trial can displace a particle of a term alone. */
static bool isDisplaceable(const ctDefinition* scene, const ctTermSet* set, int term) {
  const int* particles = set->particles + (size_t)term * (size_t)set->particlesPerTerm;
  for (int i = 0; i < set->particlesPerTerm && scene->isFlexible; i++) {
    if (vertexOf(scene, scene->particleLinks[particles[i]]) != 0) {
      return true;
    }
  }
  return false;
}

/* ---- The lists ---- */

static WideTerm makeWideTerm(const TermSet* set, int term) {
  const int* slots = set->slots + (size_t)term * (size_t)set->width;
  WideTerm wide = {set->firstTerm + term, slots[0], slots[0]};
  for (int i = 1; i < set->width; i++) {
    wide.firstSlot = slots[i] < wide.firstSlot ? slots[i] : wide.firstSlot;
    wide.lastSlot = slots[i] > wide.lastSlot ? slots[i] : wide.lastSlot;
  }
  return wide;
}

/* Counts the terms of link u in begin[u + 1], all wide terms and the changeable terms of each set. */
static size_t countTerms(const Forest* forest, int setCount, const ctTermSet* given, TermSet* sets, size_t* begin) {
  size_t wideCount = 0;
  for (int s = 0; s < setCount; s++) {
    sets[s].changeableCount = 0;
    for (int term = 0; term < given[s].count; term++) {
      const JointList joints = jointsOf(forest, &given[s], term);
      sets[s].changeableCount += joints.count > 0 || isDisplaceable(forest->scene, &given[s], term);
      if (joints.count > MOST_JOINTS) {
        wideCount++;
        continue;
      }
      for (int i = 0; i < joints.count; i++) {
        begin[joints.links[i] + 1]++;
      }
    }
  }
  return wideCount;
}

/* Fills the lists. `begin` holds where each ends when it is done, which is where the next begins. */
static void fillLists(const Forest* forest, int setCount, const ctTermSet* given, const TermSet* sets,
                      Dependence* dependence) {
  for (int s = 0; s < setCount; s++) {
    for (int term = 0; term < given[s].count; term++) {
      const JointList joints = jointsOf(forest, &given[s], term);
      if (joints.count > MOST_JOINTS) {
        const WideTerm wide = makeWideTerm(&sets[s], term);
        if (wide.firstSlot == wide.lastSlot) {
          dependence->singles[dependence->singleCount++] = wide;
        } else {
          dependence->across[dependence->acrossCount++] = wide;
        }
        continue;
      }
      for (int i = 0; i < joints.count; i++) {
        dependence->terms[dependence->begin[joints.links[i]]++] = sets[s].firstTerm + term;
      }
    }
  }
}

static int compareWideTerms(const void* a, const void* b) {
  const WideTerm* x = a;
  const WideTerm* y = b;
  return x->firstSlot != y->firstSlot ? (x->firstSlot > y->firstSlot) - (x->firstSlot < y->firstSlot)
                                      : (x->term > y->term) - (x->term < y->term);
}

static bool makeLists(const Forest* forest, int setCount, const ctTermSet* given, TermSet* sets,
                      Dependence* dependence) {
  const size_t linkCount = (size_t)forest->scene->linkCount;
  dependence->begin = calloc(linkCount + 2, sizeof *dependence->begin);
  if (dependence->begin == NULL) {
    return false;
  }
  /* One further on, so that filling the lists turns their ends into their begins. */
  size_t* begin = dependence->begin + 1;
  const size_t wideCount = countTerms(forest, setCount, given, sets, begin);
  for (size_t link = 0; link < linkCount; link++) {
    begin[link + 1] += begin[link];
  }
  dependence->terms = malloc((begin[linkCount] + 1) * sizeof *dependence->terms);
  dependence->singles = malloc((wideCount + 1) * sizeof *dependence->singles);
  dependence->across = malloc((wideCount + 1) * sizeof *dependence->across);
  if (dependence->terms == NULL || dependence->singles == NULL || dependence->across == NULL) {
    return false;
  }
  Dependence filled = *dependence;
  filled.begin = begin;
  fillLists(forest, setCount, given, sets, &filled);
  filled.begin = dependence->begin;
  *dependence = filled;
  qsort(dependence->singles, (size_t)dependence->singleCount, sizeof(WideTerm), compareWideTerms);
  qsort(dependence->across, (size_t)dependence->acrossCount, sizeof(WideTerm), compareWideTerms);
  return true;
}

bool ctDependenceCreate(const ctDefinition* scene, int setCount, const ctTermSet* given, TermSet* sets,
                        Dependence* dependence) {
  Forest forest;
  size_t most = 0;
  for (int s = 0; s < setCount; s++) {
    const size_t mostOfSet = MOST_POINTS * (size_t)given[s].particlesPerTerm;
    most = mostOfSet > most ? mostOfSet : most;
  }
  *dependence = (Dependence){0};
  const bool isMade = makeForest(scene, most, &forest) && makeLists(&forest, setCount, given, sets, dependence);
  freeForest(&forest);
  return isMade;
}

void ctDependenceFree(Dependence* dependence) {
  free(dependence->begin);
  free(dependence->terms);
  free(dependence->singles);
  free(dependence->across);
}
