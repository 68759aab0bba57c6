/* Branched molecules: what a turn moves, and that the rest of the sequence stays where it is. */
#include "check.h"

/* A planar tree of arms: link l > 0 turns about an axis along z at the hand of its parent, and has its own hand a unit
 * from there, at first in direction start[l]. Link l holds particle 2 l, on its axis at a height of its own, and its
 * hand, particle 2 l + 1; link 0's hand is at the origin. */
enum { MOST_LINKS = 400 };

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
    radii[2 * link + 1] = 0.01;
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

static void checkHands(const Tree* tree) {
  double positions[6 * MOST_LINKS];
  double hands[MOST_LINKS][2];
  ctGetPositions(tree->tree, positions);
  placeHands(tree, hands);
  for (int link = 0; link < tree->count; link++) {
    CHECK_NEAR(positions[6 * link + 3], hands[link][0], 1e-11);
    CHECK_NEAR(positions[6 * link + 4], hands[link][1], 1e-11);
    CHECK_NEAR(positions[6 * link + 5], 0, 1e-11);
  }
}

/* One turn after the other, and many at once, inner and outer mixed. */
static void turnAndCheck(Tree* tree) {
  makeTree(tree);
  checkHands(tree);
  for (int n = 1; n <= 3 * tree->count; n++) {
    ctChange changes[20] = {{0}};
    const int most = tree->count - 1 < 20 ? tree->count - 1 : 20;
    const int count = n % 3 == 0 ? most : 1;
    for (int c = 0; c < count; c++) {
      ctChange* change = &changes[n % 2 == 0 ? c : count - 1 - c]; /* inner ones first, or outer ones */
      change->link = 1 + (n * 31 + c) % (tree->count - 1);
      change->angle = 0.1 * ((n + c) % 13) - 0.55;
    }
    CHECK_SUCCESS(ctPropose(tree->tree, count, changes));
    CHECK_SUCCESS(ctCommit(tree->tree, NULL));
    for (int c = 0; c < count; c++) {
      tree->angle[changes[c].link] += changes[c].angle;
    }
    if (n % 10 == 0 || n < 10) {
      checkHands(tree);
      CHECK(ctValidate(tree->tree));
    }
  }
  /* relative transforms across branches: both frames stand at the sum of the turns above them */
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
  ctDestroy(tree->tree);
}

int main(void) {
  static Tree tree;
  const int counts[] = {2, 3, 5, 15, 16, 17, 18, 33, 100, MOST_LINKS};
  for (int n = 0; n < 10; n++) {
    tree.count = counts[n];
    for (int link = 1; link < tree.count; link++) {
      tree.parent[link] = (link - 1) / 2; /* binary */
    }
    turnAndCheck(&tree);
    for (int link = 1; link < tree.count; link++) {
      tree.parent[link] = link % 2 == 1 ? (link == 1 ? 0 : link - 2) : link - 1; /* a side chain on each link */
    }
    turnAndCheck(&tree);
    for (int link = 1; link < tree.count; link++) {
      tree.parent[link] = link <= 4 ? 0 : link - 4; /* four long arms */
    }
    turnAndCheck(&tree);
    for (int link = 1; link < tree.count; link++) {
      tree.parent[link] = link % 7 == 1 ? link / 7 : link - 1; /* branches of branches, seven links long */
    }
    turnAndCheck(&tree);
  }
  return checkResult();
}
