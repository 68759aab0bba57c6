/* Born sums of two leaves against long double: spheres that are apart, overlap, lie in one another or have no part,
 * negative scaled radii, necks and their reach, cutoffs, slots without a particle. The same bits by every instruction
 * set, and the same whichever leaf is named first. */
#include "../../chaintree/tests/check.h"
#include "../src/wide.h"
#include "bornoracle.h"

enum { LEAVES = 2, SLOTS = LEAVES * CT_LEAF_WIDTH, MOST_TYPES = 20 };

typedef struct Pair {
  int count;
  double positions[3 * SLOTS];
  double charges[SLOTS];
  double radii[SLOTS];
  double offsetRadii[SLOTS];
  double scaledRadii[SLOTS];
  int neckTypes[SLOTS];
  double neckHeights[MOST_TYPES * MOST_TYPES];
  double neckDistances[MOST_TYPES * MOST_TYPES];
  int slotOf[SLOTS];
  ctBorn description;
  Born born;
  ctLeafPositions leaves[LEAVES];
  double cutoff;
} Pair;

/* What was met. */
typedef struct Met {
  int overlapping;
  int engulfed;
  int without; /* r + s < o */
  int negative;
  int necks;
  int steep; /* s / r above that of the series, though spheres are apart */
} Met;

static Met met;
static double worst = 0; /* error of a sum, relative to the sizes of its parts */

static uint64_t chance = 88172645463325252u;

static double draw(double low, double high) {
  chance ^= chance << 13;
  chance ^= chance >> 7;
  chance ^= chance << 17;
  return low + (high - low) * ((double)(chance >> 11) * 0x1p-53);
}

static int drawInt(int count) {
  return (int)draw(0, count);
}

/* A number that is a float. */
static double drawFloat(double low, double high) {
  return (double)(float)draw(low, high);
}

/* ---- Scenes ---- */

/* Positions are multiples of 2^-20 nm, so that frames hold them as they are. */
static double drawCoordinate(double middle, double size) {
  return rint(draw(middle - size / 2, middle + size / 2) * (1 << 20)) / (1 << 20);
}

static void drawParticles(Pair* p) {
  const double sizes[] = {0.3, 0.8, 1.5};
  const double gaps[] = {0, 0.3, 0.6, 1.2, 3, 40};
  const double size = sizes[drawInt(3)];
  const double gap = gaps[drawInt(6)];
  const double offset = draw(-30, 30);
  const bool isOdd = drawInt(2) == 0;
  p->count = 0;
  for (int slot = 0; slot < SLOTS; slot++) {
    const int leaf = slot / CT_LEAF_WIDTH;
    if (slot % CT_LEAF_WIDTH != 3 && drawInt(4) == 0) {
      continue;
    }
    const int i = p->count++;
    p->slotOf[i] = slot;
    for (int d = 0; d < 3; d++) {
      p->positions[3 * i + d] = drawCoordinate(offset + (d == 0 ? leaf * gap : 0), size);
    }
    p->charges[i] = draw(-1, 1);
    p->radii[i] = drawFloat(0.1, 0.2);
    p->offsetRadii[i] = drawFloat(0.05, p->radii[i]);
    p->scaledRadii[i] = drawFloat(0.05, 0.2);
    if (isOdd) {
      const double odd[] = {0, drawFloat(-0.2, 0), drawFloat(0.2, 0.8), drawFloat(-0.8, 0.8), drawFloat(0, 0.01)};
      p->scaledRadii[i] = odd[drawInt(5)];
      p->offsetRadii[i] = drawFloat(0.01, 0.3);
    }
    p->neckTypes[i] = p->description.neckTypeCount > 0 ? drawInt(p->description.neckTypeCount) : 0;
  }
}

static void drawNecks(Pair* p) {
  const int counts[] = {0, 1, 2, MOST_TYPES};
  const int types = counts[drawInt(4)];
  p->description.neckTypeCount = types;
  for (int i = 0; i < types * types; i++) {
    p->neckHeights[i] = drawFloat(0, 0.6);
    p->neckDistances[i] = drawFloat(0.22, 0.43);
  }
  p->description.neckScale = drawInt(2) == 0 ? 0.826836 : -2.5;
  p->description.neckCut = drawFloat(0, 0.8);
}

static void makePair(Pair* p) {
  char text[200] = "";
  p->description = (ctBorn){.charges = p->charges,
                            .radii = p->radii,
                            .offsetRadii = p->offsetRadii,
                            .scaledRadii = p->scaledRadii,
                            .neckTypes = p->neckTypes,
                            .neckHeights = p->neckHeights,
                            .neckDistances = p->neckDistances,
                            .isFilled = drawInt(2) == 0,
                            .coulomb = CT_COULOMB,
                            .soluteDielectric = 1,
                            .solventDielectric = 78.5,
                            .cutoff = INFINITY};
  drawNecks(p);
  drawParticles(p);
  p->cutoff = drawInt(2) == 0 ? INFINITY : draw(0.2, 2);
  if (ctBornCreate(&p->born, LEAVES, p->count, &p->description, p->slotOf, text, sizeof text) != ctSuccess) {
    printf("ctBornCreate: %s\n", text);
    exit(1);
  }
  memset(p->leaves, 0, sizeof p->leaves);
  for (int i = 0; i < p->count; i++) {
    ctLeafPositions* leaf = &p->leaves[p->slotOf[i] / CT_LEAF_WIDTH];
    const int k = p->slotOf[i] % CT_LEAF_WIDTH;
    leaf->x[k] = p->positions[3 * i];
    leaf->y[k] = p->positions[3 * i + 1];
    leaf->z[k] = p->positions[3 * i + 2];
  }
}

/* ---- Sums ---- */

/* Sums by the kernel: those of each slot over the other leaf, and those over its own. */
typedef struct Sums {
  double cross[SLOTS];
  double own[SLOTS];
} Sums;

static void sumBy(const Wide* wide, const Pair* p, int first, Sums* sums) {
  LeafFrame frames[LEAVES];
  const BornColumns* columns = p->born.columns;
  const float squaredCutoff = isfinite(p->cutoff) ? (float)(p->cutoff * p->cutoff) : p->born.model.squaredCutoff;
  memset(sums, 0, sizeof *sums);
  for (int leaf = 0; leaf < LEAVES; leaf++) {
    wide->makeFrame(&p->leaves[leaf], columns[leaf].occupied, &frames[leaf]);
  }
  wide->bornSums(&p->born.model, squaredCutoff, frames, columns, first, 1 - first, 2 - first, sums->cross);
  for (int leaf = 0; leaf < LEAVES; leaf++) {
    wide->bornSums(&p->born.model, squaredCutoff, frames, columns, leaf, leaf, leaf + 1, sums->own);
  }
}

static void noteCase(const ctBorn* d, int i, int j, long double r) {
  const double o = d->offsetRadii[i];
  const double s = d->scaledRadii[j];
  const double distance = (double)r;
  met.without += distance + s < o;
  met.overlapping += distance + s > o && fabs(distance - s) < o;
  met.engulfed += s - distance > o;
  met.negative += s < 0 && distance + s > o;
  met.steep += s / distance > BORN_NEAR_RATIO && distance - s > o;
  met.necks += oracleNeck(d, i, j, r) != 0;
}

/* Adds what j contributes to the sum of i; how large its parts are; what the rounding of the distance is worth; and a
 * jump, if the distance is at one. */
static void addPart(const Pair* p, int i, int j, long double* sum, long double* size, long double* blur,
                    long double* jump) {
  const ctBorn* d = &p->description;
  const long double close = 3e-7L;
  const long double r = oracleDistance(p->positions, i, j);
  const long double scale = r > 1 ? r : 1; /* far away distances are rounded, too */
  const long double part = oracleSpheres(d, i, j, r);
  const long double neck = oracleNeck(d, i, j, r);
  if (fabsl(r - p->cutoff) < close * scale) {
    *jump += fabsl(oracleBornPart(d, i, j, r * (1 - 1e-9L))) + fabsl(neck);
  }
  if (r < p->cutoff) {
    const long double step = 1e-6L;
    const long double slope = fabsl(oracleBornPart(d, i, j, r + step) - oracleBornPart(d, i, j, r - step)) / (2 * step);
    *sum += part + neck;
    *size += fabsl(part) + fabsl(neck);
    *blur += slope * scale * 1.2e-7L;
    noteCase(d, i, j, r);
  }
  if (fabsl(r + d->scaledRadii[j] - d->offsetRadii[i]) < close) {
    *jump += fabsl(oracleOverlap(r + 2 * close, d->offsetRadii[i], d->scaledRadii[j]));
  }
  if (d->neckTypeCount > 0 && fabsl(r - d->radii[i] - d->radii[j] - d->neckCut) < close) {
    *jump += fabsl(oracleNeck(d, i, j, r - 2 * close));
  }
}

static void checkSum(const Pair* p, int i, bool isOwn, double found) {
  long double sum = 0;
  long double size = 0;
  long double blur = 0;
  long double jump = 0;
  for (int j = 0; j < p->count; j++) {
    if (j != i && (p->slotOf[i] / CT_LEAF_WIDTH == p->slotOf[j] / CT_LEAF_WIDTH) == isOwn) {
      addPart(p, i, j, &sum, &size, &blur, &jump);
    }
  }
  const double error = (double)(fabsl((long double)found - sum) - jump);
  /* The spheres of pairs contribute up to some 1 / o, which can nearly cancel. */
  const double bound = (double)size * 3e-7 + 1e-7 / p->offsetRadii[i] + (double)blur + 1e-9;
  worst = fmax(worst, error / bound);
  if (!(error <= bound)) {
    reportFailure("the %s sum of particle %d is %.9g, not %.9Lg, off by %.3g of %.3Lg\n", isOwn ? "own" : "cross", i,
                  found, sum, error, size);
  }
}

static bool machineHas(const Wide* wide) {
#ifdef __x86_64__
  if (strcmp(wide->name, "avx512") == 0) {
    return __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512bw");
  }
  return strcmp(wide->name, "avx2") != 0 || __builtin_cpu_supports("avx2");
#else
  (void)wide;
  return true;
#endif
}

static void checkPair(const Pair* p) {
  const Wide* sets[] = {ctFindWide("portable"), ctFindWide("avx2"), ctFindWide("avx512")};
  Sums sums;
  Sums other;
  sumBy(sets[0], p, 0, &sums);
  for (int i = 0; i < p->count; i++) {
    checkSum(p, i, false, sums.cross[p->slotOf[i]]);
    checkSum(p, i, true, sums.own[p->slotOf[i]]);
  }
  for (int slot = 0; slot < SLOTS; slot++) {
    const bool isEmpty = (p->born.columns[slot / CT_LEAF_WIDTH].occupied >> slot % CT_LEAF_WIDTH & 1) == 0;
    CHECK(!isEmpty || (sums.cross[slot] == 0 && sums.own[slot] == 0));
  }
  for (int s = 1; s < 3; s++) {
    if (machineHas(sets[s])) {
      sumBy(sets[s], p, 0, &other);
      CHECK(memcmp(&sums, &other, sizeof sums) == 0);
    }
  }
  sumBy(sets[0], p, 1, &other);
  for (int i = 0; i < p->count; i++) {
    const double parted = fabs(other.cross[p->slotOf[i]] - sums.cross[p->slotOf[i]]);
    CHECK(parted <= 1e-5 + 1e-6 * fabs(sums.cross[p->slotOf[i]]));
  }
}

/* A leaf with MANY others, all copies of one, so that its rows are added up in parts. */
static void checkManyLeaves(const Pair* p) {
  enum { MANY = 150 };
  static LeafFrame frames[MANY];
  static BornColumns columns[MANY];
  double one[MANY * CT_LEAF_WIDTH] = {0};
  double all[MANY * CT_LEAF_WIDTH] = {0};
  const Wide* wide = ctFindWide("portable");
  BornModel model = p->born.model;
  model.neckTypeCount = 0; /* there are no necks of MANY leaves */
  for (int leaf = 0; leaf < MANY; leaf++) {
    columns[leaf] = p->born.columns[leaf == 0 ? 0 : 1];
    wide->makeFrame(&p->leaves[leaf == 0 ? 0 : 1], columns[leaf].occupied, &frames[leaf]);
  }
  wide->bornSums(&model, model.squaredCutoff, frames, columns, 0, 1, 2, one);
  wide->bornSums(&model, model.squaredCutoff, frames, columns, 0, 1, MANY, all);
  for (int k = 0; k < CT_LEAF_WIDTH; k++) {
    const double sum = (MANY - 1) * one[k];
    CHECK(fabs(all[k] - sum) <= 1e-5 + 1e-5 * fabs(sum));
    CHECK(all[(MANY - 1) * CT_LEAF_WIDTH + k] == one[CT_LEAF_WIDTH + k]);
  }
}

/* Particles in one place, whatever the formula gives, leave finite sums. */
static void checkOnePlace(Pair* p) {
  double own[CT_LEAF_WIDTH] = {0};
  LeafFrame frame;
  const unsigned occupied = p->born.columns[0].occupied;
  const Wide* wide = ctFindWide("portable");
  for (int k = 0; k < CT_LEAF_WIDTH; k++) {
    p->leaves[0].x[k] = p->leaves[0].y[k] = p->leaves[0].z[k] = 1;
  }
  wide->makeFrame(&p->leaves[0], occupied, &frame);
  wide->bornSums(&p->born.model, p->born.model.squaredCutoff, &frame, p->born.columns, 0, 0, 1, own);
  for (int k = 0; k < CT_LEAF_WIDTH; k++) {
    CHECK(isfinite(own[k]));
  }
}

int main(void) {
  static Pair pair;
  for (int round = 0; round < 1500; round++) {
    makePair(&pair);
    checkPair(&pair);
    if (round % 50 == 0) {
      checkManyLeaves(&pair);
    }
    checkOnePlace(&pair);
    ctBornFree(&pair.born);
  }
  printf("worst %.3f of the bound; %d overlapping, %d engulfed, %d without part, %d negative, %d steep, %d necks\n",
         worst, met.overlapping, met.engulfed, met.without, met.negative, met.steep, met.necks);
  CHECK(met.overlapping > 1000 && met.engulfed > 1000 && met.without > 1000 && met.negative > 1000);
  CHECK(met.steep > 1000 && met.necks > 1000);
  return checkResult();
}
