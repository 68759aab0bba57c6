/* Whole energies and Born sums of random scenes against all pairs in long double: with cutoffs and without, salt,
 * surfaces, necks, rescaled radii or not, particles so near that single precision overflows. The same bits by every
 * instruction set. And descriptions that are refused. */
#define _POSIX_C_SOURCE 200809L /* setenv */

#include "wholescene.h"

typedef struct Whole {
  double nonbonded;
  double born;
  double sums[MOST_PARTICLES];
} Whole;

static double worstNonbonded = 0; /* errors, of what is allowed */
static double worstBorn = 0;
static int without = 0; /* scenes with a particle that has no Born radius */

/* ---- The oracle ---- */

static bool isExcluded(const ctNonbonded* d, int i, int j) {
  for (int n = 0; n < d->exclusionCount; n++) {
    if ((d->exclusions[n][0] == i && d->exclusions[n][1] == j) ||
        (d->exclusions[n][0] == j && d->exclusions[n][1] == i)) {
      return true;
    }
  }
  return false;
}

/* The energy of a pair, and how large the numbers are of which it is made. */
static long double oracleNonbonded(const ctNonbonded* d, int i, int j, long double r, long double* size) {
  const long double sixth = powl((d->sigmas[i] + d->sigmas[j]) / 2 / r, 6);
  const long double epsilon = 4 * sqrtl((long double)d->epsilons[i] * d->epsilons[j]);
  const long double charges = (long double)CT_COULOMB * d->charges[i] * d->charges[j];
  long double lennardJones = epsilon * sixth * (sixth - 1);
  long double coulomb = charges / r;
  /* sigma / r is off by up to two units in the last place, 1.2e-7, of which the twelfth power makes 1.4e-6. */
  *size += epsilon * sixth * (2 * sixth + 1) + fabsl(coulomb);
  if (isfinite(d->cutoff)) {
    const long double k = (d->dielectric - 1) / ((2 * d->dielectric + 1) * powl(d->cutoff, 3));
    const long double c = 3 * d->dielectric / ((2 * d->dielectric + 1) * (long double)d->cutoff);
    coulomb += charges * (k * r * r - c);
    *size += fabsl(charges) * c;
    if (r > d->switchingDistance) {
      const long double t = (r - d->switchingDistance) / (d->cutoff - (long double)d->switchingDistance);
      lennardJones *= 1 - 10 * powl(t, 3) + 15 * powl(t, 4) - 6 * powl(t, 5);
    }
  }
  return lennardJones + coulomb;
}

/* True if some distance is at a jump, by which rounding decides. */
static bool isAtJump(const WholeScene* s, int i, int j, long double r) {
  const long double close = 1e-6L;
  const ctBorn* b = &s->born;
  return fabsl(r - s->nonbonded.cutoff) < close || fabsl(r - b->cutoff) < close ||
         fabsl(r + b->scaledRadii[j] - b->offsetRadii[i]) < (b->scaledRadii[j] < 0 ? close : 0) ||
         fabsl(r + b->scaledRadii[i] - b->offsetRadii[j]) < (b->scaledRadii[i] < 0 ? close : 0) ||
         fabsl(r - b->radii[i] - b->radii[j] - b->neckCut) < close;
}

static void checkWhole(const WholeScene* s, const Whole* found) {
  static long double born[MOST_PARTICLES];
  long double nonbonded = 0, nonbondedSize = 1, energy = 0, energySize = 1;
  bool hasRadii = true;
  for (int i = 0; i < s->count; i++) {
    const long double sum = oracleBornSum(&s->born, s->count, s->positions, i, s->born.cutoff);
    born[i] = oracleBornRadius(&s->born, i, sum);
    hasRadii = hasRadii && born[i] > 0;
    if (!(fabsl(found->sums[i] - sum) <= 1e-6L * (5 + fabsl(sum)))) {
      reportFailure("the Born sum of particle %d is %.9g, not %.9Lg\n", i, found->sums[i], sum);
    }
    const long double self = oracleBornSelf(&s->born, i, born[i]);
    energy += self;
    energySize += fabsl(self) * (1 + born[i]); /* a large radius is less certain */
    for (int j = 0; j < i; j++) {
      const long double r = oracleDistance(s->positions, i, j);
      if (r < s->nonbonded.cutoff && !isExcluded(&s->nonbonded, i, j)) {
        nonbonded += oracleNonbonded(&s->nonbonded, i, j, r, &nonbondedSize);
      }
      if (r < s->born.cutoff) {
        const long double pair = oracleBornPair(&s->born, i, j, r, born[i], born[j]);
        energy += pair;
        energySize += fabsl(pair) + fabsl(s->born.charges[i] * s->born.charges[j] * s->born.shift * 100);
      }
    }
  }
  const double nonbondedError = (double)(fabsl(found->nonbonded - nonbonded) / nonbondedSize / 1e-6L);
  const double bornError = (double)(fabsl(found->born - energy) / energySize / 2e-7L);
  if (!(nonbondedError < 1)) {
    reportFailure("%d particles: the nonbonded energy is %.9g, not %.9Lg\n", s->count, found->nonbonded, nonbonded);
  }
  if (hasRadii ? !(bornError < 1) : !isnan(found->born)) {
    reportFailure("%d particles: the Born energy is %.9g, not %.9Lg\n", s->count, found->born, energy);
  }
  worstNonbonded = fmax(worstNonbonded, nonbondedError);
  worstBorn = hasRadii ? fmax(worstBorn, bornError) : worstBorn;
  without += !hasRadii;
}

/* ---- Scenes ---- */

static Whole compute(const WholeScene* s, const char* instructions) {
  static int slotOf[MOST_PARTICLES];
  char text[200] = "";
  WholeEnergy whole;
  Whole found = {.nonbonded = 0};
  setenv("CHAINTREE_SIMD", instructions, 1);
  ctChainTree* tree = createTree(s);
  findWholeSlots(tree, slotOf);
  if (ctWholeEnergyCreate(&whole, tree, s->count, &s->nonbonded, &s->born, slotOf, text, sizeof text) != ctSuccess) {
    printf("ctWholeEnergyCreate: %s\n", text);
    exit(1);
  }
  CHECK(ctWholeEnergyCompute(&whole, &found.nonbonded, &found.born) == ctSuccess);
  CHECK(ctWholeEnergyBornSums(&whole, found.sums) == ctSuccess);
  /* Nothing is kept. */
  double again[2];
  CHECK(ctWholeEnergyCompute(&whole, &again[0], &again[1]) == ctSuccess);
  CHECK(memcmp(&again[0], &found.nonbonded, sizeof(double)) == 0 &&
        memcmp(&again[1], &found.born, sizeof(double)) == 0);
  ctWholeEnergyFree(&whole);
  ctDestroy(tree);
  return found;
}

/* Moves a scene until no distance is at a jump. */
static void drawClearScene(WholeScene* s) {
  bool isClear;
  do {
    drawWholeScene(s);
    isClear = true;
    for (int i = 0; i < s->count; i++) {
      for (int j = 0; j < i; j++) {
        isClear = isClear && !isAtJump(s, i, j, oracleDistance(s->positions, i, j));
      }
    }
  } while (!isClear);
}

static void testScenes(int count) {
  static WholeScene scene;
  for (int n = 0; n < count; n++) {
    drawClearScene(&scene);
    if (n % 10 == 0 && scene.count > 40) {
      /* So near that the twelfth power is no float, and one that is excluded; Born sums take what comes. */
      for (int d = 0; d < 3; d++) {
        scene.positions[3 * 30 + d] = scene.positions[3 * 3 + d] + (d == 0 ? 0x1p-13 : 0);
      }
      scene.epsilons[3] = scene.epsilons[30] = 0.5;
    }
    const Whole found = compute(&scene, "portable");
    checkWhole(&scene, &found);
    const char* const sets[] = {"avx2", "avx512"};
    for (int i = 0; i < 2; i++) {
      const Whole other = compute(&scene, sets[i]);
      CHECK(memcmp(&found, &other, sizeof found) == 0);
    }
  }
  printf("worst errors %.3f and %.3f of what is allowed; %d scenes without a Born radius\n", worstNonbonded, worstBorn,
         without);
}

/* One pair of charges, in two clusters farther and farther apart: 1 / f is found in three ways. */
static void testRanges(void) {
  static WholeScene s;
  do {
    drawWholeScene(&s);
  } while (s.count < 2 * CT_LEAF_WIDTH);
  s.count = s.definition.particleCount = 2 * CT_LEAF_WIDTH;
  s.linkCount = s.definition.linkCount = 2;
  s.nonbonded.exclusionCount = 0;
  s.nonbonded.cutoff = s.born.cutoff = INFINITY;
  s.born.shift = s.born.kappa = 0;
  s.born.isRescaled = s.born.isFilled = false;
  s.born.neckTypeCount = 0;
  for (int n = 0; n < 60; n++) {
    for (int i = 0; i < s.count; i++) {
      s.links[i] = i / CT_LEAF_WIDTH;
      s.charges[i] = s.epsilons[i] = s.scaledRadii[i] = 0;
      for (int d = 0; d < 3; d++) {
        const double middle = d == 0 ? s.links[i] * (0.2 + 0.02 * n) : 0;
        s.positions[3 * i + d] = rint((middle + draw(-0.02, 0.02)) * (1 << 20)) / (1 << 20);
      }
    }
    s.charges[drawInt(CT_LEAF_WIDTH)] = 0.8;
    s.charges[CT_LEAF_WIDTH + drawInt(CT_LEAF_WIDTH)] = -0.7;
    const Whole found = compute(&s, "portable");
    checkWhole(&s, &found);
  }
}

/* Particles so close together that no radius is above 0: products of two are, so that pairs have energies. They fill
 * blocks, as what would have filled them has a radius above 0. */
static void testNoRadii(void) {
  static WholeScene scene;
  do {
    drawWholeScene(&scene);
  } while (scene.count < 30 || scene.count % CT_LEAF_WIDTH != 0 || scene.born.isRescaled);
  for (int i = 0; i < scene.count; i++) {
    for (int d = 0; d < 3; d++) {
      scene.positions[3 * i + d] *= 0.25;
    }
    scene.scaledRadii[i] = scene.offsetRadii[i];
  }
  for (int i = 0; i < scene.count; i++) {
    const long double sum = oracleBornSum(&scene.born, scene.count, scene.positions, i, scene.born.cutoff);
    CHECK(oracleBornRadius(&scene.born, i, sum) < 0);
  }
  const char* const sets[] = {"portable", "avx2", "avx512"};
  for (int i = 0; i < 3; i++) {
    CHECK(isnan(compute(&scene, sets[i]).born));
  }
}

/* ---- Refusals ---- */

static void checkRefusal(const WholeScene* s, const char* culprit) {
  static int slotOf[MOST_PARTICLES];
  char text[200] = "";
  Born born;
  for (int i = 0; i < s->count; i++) {
    slotOf[i] = i;
  }
  const int leaves = s->count / CT_LEAF_WIDTH + 1;
  if (ctBornCreate(&born, leaves, s->count, &s->born, slotOf, text, sizeof text) != ctInvalidArgument ||
      strstr(text, culprit) == NULL) {
    reportFailure("\"%s\" should name \"%s\"\n", text, culprit);
  }
}

static void testRefusals(void) {
  static WholeScene s;
  do {
    drawWholeScene(&s);
  } while (s.count < 20 || s.born.neckTypeCount == 0 || !s.born.isRescaled);
#define REFUSE(field, value, culprit) \
  do {                                \
    const double before = s.field;    \
    s.field = (value);                \
    checkRefusal(&s, culprit);        \
    s.field = before;                 \
  } while (0)
  REFUSE(charges[3], NAN, "particle 3");
  REFUSE(scaledRadii[4], INFINITY, "particle 4");
  REFUSE(offsetRadii[5], 0, "particle 5");
  REFUSE(radii[6], -0.1, "particle 6");
  REFUSE(alphas[7], NAN, "particle 7");
  REFUSE(neckHeights[2], NAN, "neck of types 2 and 0");
  REFUSE(born.neckScale, NAN, "scale");
  REFUSE(born.solventDielectric, 0, "dielectrics");
  REFUSE(born.kappa, -1, "kappa");
  REFUSE(born.coulomb, NAN, "Coulomb");
  REFUSE(born.surfaceEnergy, INFINITY, "surface");
  REFUSE(born.cutoff, 0, "cutoff");
#undef REFUSE
  s.neckTypes[8] = MOST_NECKS;
  checkRefusal(&s, "particle 8 has neck type 5");
}

int main(int argumentCount, char** arguments) {
  testScenes(argumentCount > 1 ? atoi(arguments[1]) : 150);
  testRanges();
  testNoRadii();
  testRefusals();
  CHECK(without > 0);
  return checkResult();
}
