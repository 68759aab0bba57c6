/* Branched molecules: what a turn moves, and that the rest of the sequence stays where it is. */
#include "check.h"

/* ---- Trees ---- */

/* A planar tree of arms: link l > 0 turns about an axis along z at the hand of its parent, and has its own hand a unit
 * from there, at first in direction start[l]. Link l holds particle 2 l, on its axis at a height of its own, and its
 * hand, particle 2 l + 1; link 0's hand is at the origin. */
enum { MOST_LINKS = 6000, MOST_CHANGES = 20 };

static const double HAND_RADIUS = 0.01;

typedef struct Tree {
  ctChainTree* tree;
  int count;
  int parent[MOST_LINKS];
  double start[MOST_LINKS];
  double angle[MOST_LINKS]; /* turned so far */
} Tree;

/* Where each hand should be: parents come before their children. */
static void placeHands(const Tree* tree, double (*hands)[2]) {
  double sums[MOST_LINKS] = {0};
  for (int link = 0; link < tree->count; link++) {
    hands[link][0] = hands[link][1] = 0;
    if (link > 0) {
      const int parent = tree->parent[link];
      sums[link] = sums[parent] + tree->angle[link];
      hands[link][0] = hands[parent][0] + cos(sums[link] + tree->start[link]);
      hands[link][1] = hands[parent][1] + sin(sums[link] + tree->start[link]);
    }
  }
}

static void makeTree(Tree* tree) {
  double positions[6 * MOST_LINKS];
  double radii[2 * MOST_LINKS];
  int particleLinks[2 * MOST_LINKS];
  uint8_t joints[MOST_LINKS];
  int torsions[MOST_LINKS][4] = {{0}};
  double hands[MOST_LINKS][2];
  memset(tree->angle, 0, sizeof tree->angle);
  for (int link = 0; link < tree->count; link++) {
    tree->start[link] = 2.399963 * link;
    joints[link] = link == 0 ? ctFixedJoint : ctTorsionJoint;
  }
  tree->parent[0] = CT_NULL;
  placeHands(tree, hands);
  for (int link = 0; link < tree->count; link++) {
    const int parent = tree->parent[link] < 0 ? 0 : tree->parent[link];
    const double own[6] = {hands[parent][0], hands[parent][1], 1 + 0.01 * link, hands[link][0], hands[link][1], 0};
    memcpy(positions + 6 * link, own, sizeof own);
    const int torsion[4] = {2 * parent, 2 * parent + 1, 2 * link, 2 * link + 1};
    memcpy(torsions[link], torsion, sizeof torsion);
    particleLinks[2 * link] = particleLinks[2 * link + 1] = link;
    radii[2 * link] = 0; /* the axis is not modelled */
    radii[2 * link + 1] = HAND_RADIUS;
  }
  const ctDefinition definition = {.particleCount = 2 * tree->count,
                                   .positions = positions,
                                   .radii = radii,
                                   .particleLinks = particleLinks,
                                   .linkCount = tree->count,
                                   .linkParents = tree->parent,
                                   .linkJoints = joints,
                                   .linkTorsions = (const int(*)[4])torsions};
  tree->tree = checkedCreate(&definition);
}

/* The sums over a thousand angles have their own rounding. */
static void checkHands(const Tree* tree) {
  double positions[6 * MOST_LINKS];
  double hands[MOST_LINKS][2];
  ctGetPositions(tree->tree, positions);
  placeHands(tree, hands);
  for (int link = 0; link < tree->count; link++) {
    CHECK_NEAR(positions[6 * link + 3], hands[link][0], 1e-9);
    CHECK_NEAR(positions[6 * link + 4], hands[link][1], 1e-9);
    CHECK_NEAR(positions[6 * link + 5], 0, 1e-9);
  }
}

/* ---- Trials ---- */

static double apart(double (*hands)[2], int a, int b) {
  return hypot(hands[a][0] - hands[b][0], hands[a][1] - hands[b][1]);
}

/* Pairs of hands that come nearer or go farther, and their distances by the angles. */
typedef struct Expected {
  double before[MOST_LINKS][2];
  double after[MOST_LINKS][2];
  double cutoff;
  int listed;
} Expected;

static bool isChanged(Expected* expected, int a, int b) {
  return fabs(apart(expected->before, a, b) - apart(expected->after, a, b)) > 1e-9;
}

static bool checkChangedPair(void* context, int particle1, int particle2, double before, double after) {
  Expected* expected = context;
  const int a = particle1 / 2;
  const int b = particle2 / 2;
  CHECK_NEAR(before, apart(expected->before, a, b), 1e-11);
  CHECK_NEAR(after, apart(expected->after, a, b), 1e-11);
  CHECK(fmin(before, after) <= expected->cutoff);
  expected->listed += isChanged(expected, a, b);
  return true;
}

/* The open trial's verdict and changed pairs. `tree` has the angles of the trial already. */
static void checkTrial(const Tree* tree, Expected* expected) {
  placeHands(tree, expected->after);
  expected->cutoff = 0.7;
  expected->listed = 0;
  int near = 0;
  bool clashes = false;
  for (int a = 0; a < tree->count; a++) {
    for (int b = 0; b < a; b++) {
      if (isChanged(expected, a, b)) {
        const double after = apart(expected->after, a, b);
        near += fmin(after, apart(expected->before, a, b)) <= expected->cutoff;
        clashes = clashes || after < 2 * HAND_RADIUS;
      }
    }
  }
  bool clash;
  int pair[2];
  CHECK_SUCCESS(ctForEachChangedPair(tree->tree, expected->cutoff, checkChangedPair, expected, NULL));
  CHECK(expected->listed == near);
  CHECK_SUCCESS(ctTestTrial(tree->tree, &clash, pair, NULL));
  CHECK(clash || !clashes);
  CHECK(!clash || apart(expected->after, pair[0] / 2, pair[1] / 2) < 2 * HAND_RADIUS);
}

/* Turns of one joint, or of many at once, inner ones first or outer ones. */
static int chooseChanges(Tree* tree, int n, ctChange* changes) {
  const int most = tree->count - 1 < MOST_CHANGES ? tree->count - 1 : MOST_CHANGES;
  const int count = n % 3 == 0 ? most : 1;
  for (int c = 0; c < count; c++) {
    ctChange* change = &changes[n % 2 == 0 ? c : count - 1 - c];
    change->link = 1 + (n * 31 + c) % (tree->count - 1);
    change->angle = 0.1 * ((n + c) % 13) - 0.55;
    tree->angle[change->link] += change->angle;
  }
  return count;
}

static void turnAndCheck(Tree* tree) {
  makeTree(tree);
  checkHands(tree);
  for (int n = 1; n <= 3 * tree->count && n <= 1200; n++) {
    static Expected expected;
    ctChange changes[MOST_CHANGES] = {{0}};
    const bool isTrialChecked = n <= 24 && tree->count <= 400; /* it takes a time of their number squared */
    if (isTrialChecked) {
      placeHands(tree, expected.before);
    }
    const int count = chooseChanges(tree, n, changes);
    CHECK_SUCCESS(ctPropose(tree->tree, count, changes));
    if (isTrialChecked) {
      checkTrial(tree, &expected);
    }
    CHECK_SUCCESS(ctAccept(tree->tree, NULL));
    if (n % (10 + tree->count / 50) == 0 || n < 10) {
      checkHands(tree);
      CHECK(ctValidate(tree->tree));
    }
  }
}

/* Across branches: both frames stand at the sum of the turns above them. */
static void checkFrames(const Tree* tree) {
  double sums[MOST_LINKS] = {0};
  for (int link = 1; link < tree->count; link++) {
    sums[link] = sums[tree->parent[link]] + tree->angle[link];
  }
  for (int n = 0; n < 100; n++) {
    const int a = n * 17 % tree->count;
    const int b = n * 29 % tree->count;
    ctTransform transform;
    CHECK_SUCCESS(ctGetRelativeTransform(tree->tree, a, b, &transform));
    CHECK_NEAR(transform.rotation[0], cos(sums[b] - sums[a]), 1e-11);
    CHECK_NEAR(transform.rotation[3], sin(sums[b] - sums[a]), 1e-11);
    CHECK_NEAR(transform.rotation[8], 1, 1e-11);
  }
}

typedef enum Shape { BINARY, COMB, LONG_TEETH, FOUR_ARMS, BRANCHED_BRANCHES, SHAPES } Shape;

static int parentIn(Shape shape, int link) {
  switch (shape) {
    case BINARY:
      return (link - 1) / 2;
    case COMB:
      return link % 2 == 1 ? (link == 1 ? 0 : link - 2) : link - 1;
    case LONG_TEETH: /* four links each */
      return link % 5 == 1 ? (link == 1 ? 0 : link - 5) : link - 1;
    case FOUR_ARMS:
      return link <= 4 ? 0 : link - 4;
    default: /* seven links long */
      return link % 7 == 1 ? link / 7 : link - 1;
  }
}

/* A part of a tooth of a comb turns, as a side chain does: all else stays where it is, bit by bit. */
static void turnTeeth(Tree* tree) {
  tree->count = 400;
  for (int link = 1; link < tree->count; link++) {
    tree->parent[link] = parentIn(LONG_TEETH, link);
  }
  makeTree(tree);
  double before[6 * MOST_LINKS];
  double after[6 * MOST_LINKS];
  /* Particles that have not moved keep the positions that the caller gave. */
  CHECK_SUCCESS(ctPropose(tree->tree, 1, &(ctChange){.link = 1, .angle = tree->angle[1] = 0.2}));
  CHECK_SUCCESS(ctAccept(tree->tree, NULL));
  for (int turned = 2; turned < tree->count; turned++) {
    if (turned % 5 == 1) { /* in the comb's back */
      continue;
    }
    ctGetPositions(tree->tree, before);
    CHECK_SUCCESS(ctPropose(tree->tree, 1, &(ctChange){.link = turned, .angle = 0.3 * turned}));
    CHECK_SUCCESS(ctAccept(tree->tree, NULL));
    tree->angle[turned] += 0.3 * turned;
    ctGetPositions(tree->tree, after);
    const int toothEnd = (turned + 3) / 5 * 5 + 1;
    for (int link = 0; link < tree->count; link++) {
      const bool same = memcmp(before + 6 * link + 3, after + 6 * link + 3, 3 * sizeof(double)) == 0;
      CHECK(same == (link < turned || link >= toothEnd));
    }
  }
  checkHands(tree);
  CHECK(ctValidate(tree->tree));
  ctDestroy(tree->tree);
}

int main(void) {
  static Tree tree;
  const int counts[] = {2, 3, 5, 15, 16, 17, 18, 33, 100, 400, MOST_LINKS};
  for (int n = 0; n < 11; n++) {
    for (Shape shape = BINARY; shape < SHAPES; shape++) {
      tree.count = counts[n];
      for (int link = 1; link < tree.count; link++) {
        tree.parent[link] = parentIn(shape, link);
      }
      turnAndCheck(&tree);
      checkFrames(&tree);
      ctDestroy(tree.tree);
    }
  }
  turnTeeth(&tree);
  return checkResult();
}
