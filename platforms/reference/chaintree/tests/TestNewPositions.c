/* The first query after new positions has the bits that it has when everything is up to date. */
#include "lattice.h"

/* A number for every bit of an answer. */
typedef struct Answer {
  uint64_t hash;
  int count;
} Answer;

static void add(Answer* answer, const void* data, size_t size) {
  const unsigned char* bytes = data;
  for (size_t i = 0; i < size; i++) {
    answer->hash = (answer->hash ^ bytes[i]) * 1099511628211u;
  }
  answer->count++;
}

static bool addPair(void* context, int particle1, int particle2, double value) {
  const int pair[] = {particle1, particle2};
  add(context, pair, sizeof pair);
  add(context, &value, sizeof value);
  return true;
}

static bool addChangedPair(void* context, int particle1, int particle2, double before, double after) {
  return addPair(context, particle1, particle2, before) && addPair(context, particle1, particle2, after);
}

static bool addParticle(void* context, int particle, double overlap) {
  return addPair(context, particle, particle, overlap);
}

/* ---- The questions ---- */

typedef void Question(ctChainTree* tree, Answer* answer);

enum { MOVED = SIDE / 2 }; /* a link that can move in every scene but the fixed one */

static void askEnergy(ctChainTree* tree, Answer* answer) {
  static double forces[3 * SITES];
  double energy;
  memset(forces, 0, sizeof forces);
  CHECK_SUCCESS(ctComputeEnergy(tree, 3, &energy, forces, NULL));
  add(answer, &energy, sizeof energy);
  add(answer, forces, sizeof forces);
}

static void askClashes(ctChainTree* tree, Answer* answer) {
  CHECK_SUCCESS(ctForEachClash(tree, addPair, answer, NULL));
}

static void askFirstClash(ctChainTree* tree, Answer* answer) {
  bool clash;
  int pair[2] = {CT_NULL, CT_NULL};
  CHECK_SUCCESS(ctHasClash(tree, &clash, pair, NULL));
  add(answer, pair, sizeof pair);
}

static void askNeighbors(ctChainTree* tree, Answer* answer) {
  CHECK_SUCCESS(ctForEachNeighborPair(tree, 1.5, addPair, answer, NULL));
}

static void askProbe(ctChainTree* tree, Answer* answer) {
  const double position[] = {4.2, 3.9, 4.1};
  CHECK_SUCCESS(ctForEachClashWith(tree, position, 1, addParticle, answer, NULL));
}

static void askMinimum(ctChainTree* tree, Answer* answer) {
  const int first[] = {0, 1, 2};
  const int second[] = {SITES - 2, SITES - 1};
  double distance;
  int pair[2];
  CHECK_SUCCESS(minimumDistance(tree, 3, first, 2, second, &distance, pair));
  add(answer, &distance, sizeof distance);
  add(answer, pair, sizeof pair);
}

static void askPositions(ctChainTree* tree, Answer* answer) {
  static double positions[3 * SITES];
  ctGetPositions(tree, positions);
  add(answer, positions, sizeof positions);
}

static void askState(ctChainTree* tree, Answer* answer) {
  const size_t size = ctGetStateSize(tree);
  double* state = malloc(size * sizeof(double));
  ctGetState(tree, state);
  add(answer, state, size * sizeof(double));
  free(state);
}

static void askCentroid(ctChainTree* tree, Answer* answer) {
  double centroid[3] = {0, 0, 0};
  if (ctGetCentroid(tree, MOVED, centroid) == ctSuccess) {
    add(answer, centroid, sizeof centroid);
  }
}

static void askTransform(ctChainTree* tree, Answer* answer) {
  ctTransform transform;
  CHECK_SUCCESS(ctGetRelativeTransform(tree, 0, 0, &transform));
  add(answer, &transform, sizeof transform);
  if (ctGetRelativeTransform(tree, MOVED, 0, &transform) == ctSuccess) {
    add(answer, &transform, sizeof transform);
  }
}

static void askLimits(ctChainTree* tree, Answer* answer) {
  int raised;
  CHECK_SUCCESS(ctRaiseLimits(tree, &raised, NULL));
  const int count = ctGetLimitCount(tree);
  int(*pairs)[2] = malloc((size_t)(count + 1) * sizeof *pairs);
  double* limits = malloc((size_t)(count + 1) * sizeof *limits);
  ctGetLimits(tree, count, pairs, limits);
  add(answer, pairs, (size_t)count * sizeof *pairs);
  add(answer, limits, (size_t)count * sizeof *limits);
  free(pairs);
  free(limits);
  CHECK_SUCCESS(ctSetLimits(tree, 0, NULL, NULL));
}

/* A trial, and the answers about where it leads. */
static void askTrial(ctChainTree* tree, Answer* answer) {
  const ctChange change = {.link = MOVED, .angle = 0.1, .translation = {0.1, 0.05, 0}};
  if (ctPropose(tree, 1, &change) == ctSuccess) {
    static double positions[3 * SITES];
    bool clash;
    CHECK_SUCCESS(ctTestTrial(tree, &clash, NULL, NULL));
    add(answer, &clash, sizeof clash);
    CHECK_SUCCESS(ctForEachChangedPair(tree, 1.5, addChangedPair, answer, NULL));
    CHECK_SUCCESS(ctGetTrialPositions(tree, positions));
    add(answer, positions, sizeof positions);
    CHECK_SUCCESS(ctAccept(tree, NULL));
    askEnergy(tree, answer);
    askNeighbors(tree, answer);
  }
}

static Question* const questions[] = {askEnergy,    askClashes, askFirstClash, askNeighbors, askProbe,  askMinimum,
                                      askPositions, askState,   askCentroid,   askTransform, askLimits, askTrial};

/* ---- New positions ---- */

static void shake(double positions[3 * SITES], unsigned seed) {
  for (int i = 0; i < SITES; i++) {
    int site[3];
    latticeSite(i, site);
    for (int k = 0; k < 3; k++) {
      seed = seed * 1664525u + 1013904223u;
      positions[3 * i + k] = site[k] + 0.3 * (double)(seed >> 8) / (1 << 24);
    }
  }
}

static Answer ask(ctChainTree* tree, Question* question) {
  Answer answer = {14695981039346656037u, 0};
  question(tree, &answer);
  return answer;
}

static void testScene(LatticeLinks links) {
  static double positions[3 * SITES];
  ctChainTree* tree = makeLattice(links, 0.45, 0.02);
  for (unsigned i = 0; i < sizeof questions / sizeof questions[0]; i++) {
    ask(tree, askTrial); /* leaves the scene displaced, with everything made */
    shake(positions, i);
    CHECK_SUCCESS(ctSetPositions(tree, positions));
    const Answer first = ask(tree, questions[i]);
    CHECK_SUCCESS(ctSetPositions(tree, positions));
    CHECK(ctValidate(tree));
    const Answer second = ask(tree, questions[i]);
    CHECK(first.hash == second.hash && first.count == second.count);
  }
  ctDestroy(tree);
}

/* A state has the same bits, whether it is the reference because nothing has moved or because all has moved back. */
static void testReturn(void) {
  static double positions[3 * SITES];
  ctChainTree* tree = makeLattice(ONE_CHAIN, 0.45, 0.02);
  shake(positions, 1);
  CHECK_SUCCESS(ctSetPositions(tree, positions));
  Answer answers[2][2];
  answers[0][0] = ask(tree, askEnergy);
  answers[0][1] = ask(tree, askNeighbors);
  for (int sign = -1; sign < 2; sign += 2) {
    const ctChange change = {.link = SITES / 2, .angle = sign * 0.25};
    CHECK_SUCCESS(ctPropose(tree, 1, &change));
    CHECK_SUCCESS(ctAccept(tree, NULL));
    answers[1][0] = ask(tree, askEnergy);
    answers[1][1] = ask(tree, askNeighbors);
    CHECK((answers[0][0].hash == answers[1][0].hash) == (sign == 1));
    CHECK((answers[0][1].hash == answers[1][1].hash) == (sign == 1));
  }
  ctDestroy(tree);
}

int main(void) {
  for (int links = 0; links < latticeLinkings; links++) {
    testScene(links);
  }
  testReturn();
  return checkResult();
}
