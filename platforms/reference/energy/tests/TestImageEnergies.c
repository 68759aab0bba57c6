/* Energies in periodic boxes, and their changes in trials, against sums over nearest images of the callers' positions
 * in double, on each instruction set. */
#define _POSIX_C_SOURCE 200112L /* setenv */

enum { CHAINS = 7, TRIALS = 60 };

#include "../../chaintree/tests/periodic.h"
#include "ctenergy.h"

enum {
  PAIRS = PARTICLES / 2,
  BONDS = CHAINS * (BEADS - 1),
  ANGLES = CHAINS * (BEADS - 2),
  TORSIONS = CHAINS * (BEADS - 3)
};

/* Everything that an energy is made from. */
typedef struct Model {
  Scene scene;
  uint8_t listed[PARTICLES];
  double charges[PARTICLES];
  double sigmas[PARTICLES];
  double epsilons[PARTICLES];
  int first[PARTICLES];
  int all[PARTICLES];
  int bonds[BONDS][2];
  double bondParameters[BONDS][2];
  int angles[ANGLES][3];
  double angleParameters[ANGLES][2];
  int torsions[TORSIONS][4];
  double torsionParameters[TORSIONS][3];
  int pairs[PAIRS][2];
  double places[PARTICLES][2];
  int groups[PAIRS][4];
  double weights[PAIRS][4];
  double cutoff;
} Model;

static const ctOperation pairOperations[] = {{ctInputOperator, {0}, 0},       {ctMultiplyConstantOperator, {0}, -3},
                                             {ctExpOperator, {1}, 0},         {ctParameterOperator, {0}, 0},
                                             {ctMultiplyOperator, {2, 3}, 0}, {ctParameterOperator, {1}, 0},
                                             {ctMultiplyOperator, {4, 5}, 0}};
static const ctOperation squareOfDistance[] = {{ctInputOperator, {0}, 0}, {ctSquareOperator, {0}, 0}};
static const ctInput distanceInput = {ctMeasureDistance, {0, 1}};
static const ctExpression squareExpression = {1, &distanceInput, 2, squareOfDistance};
/* Not the same for two images of a particle: the distance from the place (p0, 0, p1) of (x, 0, z), times x. */
static const ctInput placeInputs[] = {{ctMeasureX, {0}}, {ctMeasureZ, {0}}};
static const ctOperation placeOperations[] = {{ctInputOperator, {0}, 0},       {ctParameterOperator, {0}, 0},
                                              {ctSubtractOperator, {0, 1}, 0}, {ctConstantOperator, {0}, 0},
                                              {ctInputOperator, {1}, 0},       {ctParameterOperator, {1}, 0},
                                              {ctSubtractOperator, {4, 5}, 0}, {ctImageLengthOperator, {2, 3, 6}, 0},
                                              {ctMultiplyOperator, {0, 7}, 0}};
static const ctExpression placeExpression = {2, placeInputs, 9, placeOperations};

/* The values: the sum over pairs of q' exp(-r); its square and q. The energy: that times x / 10, and with the values v
 * of two particles v v' exp(-3 r), of excluded pairs too, and v v' exp(-r), which is too large for floats on the way.
 */
static const ctOperation sumOperations[] = {{ctInputOperator, {0}, 0},
                                            {ctNegateOperator, {0}, 0},
                                            {ctExpOperator, {1}, 0},
                                            {ctParameterOperator, {3}, 0},
                                            {ctMultiplyOperator, {2, 3}, 0}};
static const ctOperation squareOperations[] = {{ctParameterOperator, {1}, 0},
                                               {ctSquareOperator, {0}, 0},
                                               {ctParameterOperator, {0}, 0},
                                               {ctAddOperator, {1, 2}, 0}};
static const ctOperation coordinateOperations[] = {{ctParameterOperator, {2}, 0},
                                                   {ctParameterOperator, {3}, 0},
                                                   {ctMultiplyOperator, {0, 1}, 0},
                                                   {ctMultiplyConstantOperator, {2}, 0.1}};
static const ctOperation productOperations[] = {{ctInputOperator, {0}, 0},       {ctMultiplyConstantOperator, {0}, -3},
                                                {ctExpOperator, {1}, 0},         {ctParameterOperator, {2}, 0},
                                                {ctMultiplyOperator, {2, 3}, 0}, {ctParameterOperator, {5}, 0},
                                                {ctMultiplyOperator, {4, 5}, 0}};
static const ctOperation largeOperations[] = {{ctInputOperator, {0}, 0},
                                              {ctNegateOperator, {0}, 0},
                                              {ctExpOperator, {1}, 0},
                                              {ctMultiplyConstantOperator, {2}, 1e60},
                                              {ctParameterOperator, {2}, 0},
                                              {ctMultiplyOperator, {3, 4}, 0},
                                              {ctParameterOperator, {5}, 0},
                                              {ctMultiplyOperator, {5, 6}, 0},
                                              {ctMultiplyConstantOperator, {7}, 1e-60}};
static const ctValueExpression valuesOfParticles[] = {{ctOfPairs, 5, sumOperations, 0, NULL},
                                                      {ctOfParticles, 4, squareOperations, 0, NULL}};
static const ctValueExpression termsOfValues[] = {{ctOfParticles, 4, coordinateOperations, 0, NULL},
                                                  {ctOfAllPairs, 7, productOperations, 0, NULL},
                                                  {ctOfPairs, 9, largeOperations, 0, NULL}};

static void fillModel(Model* m, double width) {
  for (int i = 0; i < PARTICLES; i++) {
    m->listed[i] = 1;
    m->charges[i] = drawnBetween(-0.5, 0.5);
    m->sigmas[i] = drawnBetween(0.01, 0.03);
    m->epsilons[i] = drawnBetween(0, 0.5);
    m->first[i] = 2 * i % PARTICLES;
    m->all[i] = i;
  }
  m->sigmas[3] = 1e10; /* overflows in single precision */
  m->epsilons[3] = 0;
  for (int c = 0, bond = 0, angle = 0, torsion = 0; c < CHAINS; c++) {
    for (int i = c * BEADS; i < (c + 1) * BEADS; i++) {
      for (int k = 0; k < 2 && i > c * BEADS; k++) {
        m->bonds[bond][k] = i - k;
        m->bondParameters[bond][k] = 0.3 + k;
      }
      bond += i > c * BEADS;
      for (int k = 0; k < 3 && i > c * BEADS + 1; k++) {
        m->angles[angle][k] = i - k;
        m->angleParameters[angle][k / 2] = 2;
      }
      angle += i > c * BEADS + 1;
      for (int k = 0; k < 4 && i > c * BEADS + 2; k++) {
        m->torsions[torsion][k] = i - k;
        m->torsionParameters[torsion][k % 3] = 1 + k % 2;
      }
      torsion += i > c * BEADS + 2;
    }
  }
  for (int i = 0; i < PAIRS; i++) { /* of a molecule and of two, also of the rigid body */
    m->pairs[i][0] = i;
    m->pairs[i][1] = PARTICLES - 1 - i / 3;
    for (int k = 0; k < 4; k++) { /* groups of two molecules */
      m->groups[i][k] = (i + k * (BEADS + 3)) % PARTICLES;
      m->weights[i][k] = 1 + k;
    }
  }
  for (int i = 0; i < PARTICLES; i++) {
    for (int k = 0; k < 2; k++) {
      m->places[i][k] = drawnBetween(-3, 3);
    }
  }
  m->cutoff = width / 2;
}

enum { SETS = 9 };

/* Energies of all kinds by number: nonbonded, a pair set, then term sets. */
typedef struct Energies {
  double value[2 + SETS];
  double size; /* the sum of magnitudes of pairs, more of near ones, whose distances round more */
} Energies;

static double switched(double r, double from, double to) {
  const double t = r > from ? (r - from) / (to - from) : 0;
  return 1 + t * t * t * (-10 + t * (15 - 6 * t));
}

/* The length of a difference of positions, or of its nearest image. */
static double lengthOf(const double difference[3], const double (*box)[3]) {
  double pair[6] = {0};
  int n[3] = {0, 0, 0};
  memcpy(pair, difference, 3 * sizeof *pair);
  if (box != NULL) {
    nearestImage(pair, 0, 1, box, n);
  }
  return (double)imageDistance(pair, 0, 1, box != NULL ? box : boxes[0], n);
}

static double termOf(const ctTermSet* set, int term, const double (*x)[3], const double (*box)[3]) {
  const double* p = set->parameters + (size_t)term * (size_t)set->parametersPerTerm;
  if (set->particlesPerTerm == 1) {
    const double difference[3] = {x[0][0] - p[0], 0, x[0][2] - p[1]};
    return x[0][0] * lengthOf(difference, box);
  }
  if (set->kind == ctCentroidTerm) {
    double difference[3];
    for (int i = 0; i < 3; i++) {
      difference[i] =
          (p[0] * x[0][i] + p[1] * x[1][i]) / (p[0] + p[1]) - (p[2] * x[2][i] + p[3] * x[3][i]) / (p[2] + p[3]);
    }
    return pow(lengthOf(difference, box), 2);
  }
  double d[3][3] = {{0}};
  double normal[2][3] = {{0}};
  for (int k = 0; k < set->particlesPerTerm - 1; k++) {
    for (int i = 0; i < 3; i++) {
      d[k][i] = x[k + 1][i] - x[k][i];
    }
  }
  double products[3] = {0, 0, 0}; /* of the first difference with itself, with the next, and of that with itself */
  for (int i = 0; i < 3; i++) {
    products[0] += d[0][i] * d[0][i];
    products[1] -= set->particlesPerTerm > 2 ? d[0][i] * d[1][i] : 0;
    products[2] += set->particlesPerTerm > 2 ? d[1][i] * d[1][i] : 0;
  }
  if (set->kind == ctExpressionTerm) {
    return products[0];
  }
  if (set->particlesPerTerm == 2) {
    return 0.5 * p[1] * (sqrt(products[0]) - p[0]) * (sqrt(products[0]) - p[0]);
  }
  if (set->particlesPerTerm == 3) {
    const double bend = acos(fmax(-1, fmin(1, products[1] / sqrt(products[0] * products[2])))) - p[0];
    return 0.5 * p[1] * bend * bend;
  }
  for (int k = 0; k < 2; k++) {
    for (int i = 0; i < 3; i++) {
      normal[k][i] = d[k][(i + 1) % 3] * d[k + 1][(i + 2) % 3] - d[k][(i + 2) % 3] * d[k + 1][(i + 1) % 3];
    }
  }
  double cosine = 0;
  double sine = 0;
  for (int i = 0; i < 3; i++) {
    cosine += normal[0][i] * normal[1][i];
    sine += d[0][i] * normal[1][i] * sqrt(products[2]);
  }
  return p[2] * (1 + cos(p[0] * atan2(sine, cosine) - p[1]));
}

static void computeEnergies(const Model* m, const ctEnergyDefinition* d, const double (*box)[3],
                            const double* positions, Energies* energies) {
  *energies = (Energies){{0}, 0};
  const double c = m->cutoff;
  const double k = (d->nonbonded->dielectric - 1) / (2 * d->nonbonded->dielectric + 1) / (c * c * c);
  const double shift = 3 * d->nonbonded->dielectric / (2 * d->nonbonded->dielectric + 1) / c;
  for (int i = 0; i < PARTICLES; i++) {
    for (int j = 0; j < i; j++) {
      int n[3];
      nearestImage(positions, i, j, box, n);
      const double r = (double)imageDistance(positions, i, j, box, n);
      if (isExcluded(&m->scene, i, j) || r >= c) {
        continue;
      }
      const double ratio = pow((m->sigmas[i] + m->sigmas[j]) / 2 / r, 6);
      const double lennardJones = 4 * sqrt(m->epsilons[i] * m->epsilons[j]) * (ratio * ratio - ratio) *
                                  switched(r, d->nonbonded->switchingDistance, c);
      const double alpha = d->nonbonded->ewaldAlpha;
      const double coulomb =
          CT_COULOMB * m->charges[i] * m->charges[j] * (alpha > 0 ? erfc(alpha * r) / r : 1 / r + k * r * r - shift);
      energies->value[0] += lennardJones + coulomb;
      energies->size += (fabs(lennardJones) + fabs(coulomb)) * (1 + 1 / r);
      if ((i % 2 == 0 || j % 2 == 0) && r < d->pairSets[0].cutoff) {
        energies->value[1] += exp(-3 * r) * m->charges[i] * m->charges[j];
      }
    }
  }
  for (int s = 0; s < d->termSetCount; s++) {
    const ctTermSet* set = &d->termSets[s];
    for (int term = 0; term < set->count; term++) {
      double x[4][3];
      const int* own = set->particles + (size_t)term * (size_t)set->particlesPerTerm;
      memcpy(x[0], positions + 3 * (size_t)own[0], sizeof x[0]);
      for (int p = 1; p < set->particlesPerTerm; p++) {
        int n[3] = {0, 0, 0};
        if (set->isPeriodic && set->kind != ctCentroidTerm) {
          nearestImage(positions, own[p], own[p - 1], box, n);
        }
        for (int e = 0; e < 3; e++) {
          x[p][e] = x[p - 1][e] + (positions[3 * own[p] + e] - positions[3 * own[p - 1] + e]) + n[0] * box[0][e] +
                    n[1] * box[1][e] + n[2] * box[2][e];
        }
      }
      energies->value[2 + s] += termOf(set, term, (const double(*)[3])x, set->isPeriodic ? box : NULL);
    }
  }
}

/* The value energy, and the sum of the magnitudes of its pairs. */
static double computeValueEnergy(const Model* m, const double (*box)[3], const double* positions, double* size) {
  static double distances[PARTICLES][PARTICLES];
  double values[PARTICLES] = {0};
  double energy = 0;
  *size = 1;
  for (int i = 0; i < PARTICLES; i++) {
    for (int j = 0; j < i; j++) {
      int n[3];
      nearestImage(positions, i, j, box, n);
      const double r = (double)imageDistance(positions, i, j, box, n);
      distances[i][j] = r;
      if (r < m->cutoff && !isExcluded(&m->scene, i, j)) {
        values[i] += m->charges[j] * exp(-r);
        values[j] += m->charges[i] * exp(-r);
      }
    }
  }
  for (int i = 0; i < PARTICLES; i++) {
    values[i] = values[i] * values[i] + m->charges[i];
    energy += 0.1 * values[i] * positions[3 * i];
    *size += fabs(0.1 * values[i] * positions[3 * i]);
    for (int j = 0; j < i; j++) {
      const double r = distances[i][j];
      if (r < m->cutoff) {
        const double ofPair = values[i] * values[j] * (exp(-3 * r) + (isExcluded(&m->scene, i, j) ? 0 : exp(-r)));
        energy += ofPair;
        *size += fabs(ofPair);
      }
    }
  }
  return energy;
}

/* Describes the energy in arrays that are kept by the caller. */
static ctEnergyDefinition describeEnergy(const Model* m, const ctDefinition* scene, ctNonbonded* nonbonded,
                                         ctPairSet* pairSet, ctInteractionGroup* group, ctTermSet sets[SETS],
                                         ctValueEnergy* values) {
  *nonbonded = (ctNonbonded){.charges = m->charges,
                             .sigmas = m->sigmas,
                             .epsilons = m->epsilons,
                             .cutoff = m->cutoff,
                             .switchingDistance = 0.7 * m->cutoff,
                             .dielectric = 60,
                             .exclusionCount = scene->exclusionCount,
                             .exclusions = scene->exclusions};
  *group = (ctInteractionGroup){{PARTICLES, PARTICLES}, {m->first, m->all}};
  *pairSet = (ctPairSet){.operationCount = 7,
                         .operations = pairOperations,
                         .parametersPerParticle = 1,
                         .parameters = m->charges,
                         .cutoff = 0.8 * m->cutoff,
                         .switchingDistance = INFINITY,
                         .exclusionCount = scene->exclusionCount,
                         .exclusions = scene->exclusions,
                         .groupCount = 1,
                         .groups = group};
  *values = (ctValueEnergy){.parametersPerParticle = 1,
                            .parameters = m->charges,
                            .valueCount = 2,
                            .values = valuesOfParticles,
                            .termCount = 3,
                            .terms = termsOfValues,
                            .cutoff = m->cutoff,
                            .exclusionCount = scene->exclusionCount,
                            .exclusions = scene->exclusions};
  sets[0] = (ctTermSet){.kind = ctHarmonicBondTerm,
                        .count = BONDS,
                        .particlesPerTerm = 2,
                        .particles = &m->bonds[0][0],
                        .parametersPerTerm = 2,
                        .parameters = &m->bondParameters[0][0]};
  sets[1] = sets[0];
  sets[1].isPeriodic = true;
  sets[2] = (ctTermSet){.kind = ctHarmonicAngleTerm,
                        .count = ANGLES,
                        .particlesPerTerm = 3,
                        .particles = &m->angles[0][0],
                        .parametersPerTerm = 2,
                        .parameters = &m->angleParameters[0][0],
                        .isPeriodic = true};
  sets[3] = (ctTermSet){.kind = ctPeriodicTorsionTerm,
                        .count = TORSIONS,
                        .particlesPerTerm = 4,
                        .particles = &m->torsions[0][0],
                        .parametersPerTerm = 3,
                        .parameters = &m->torsionParameters[0][0],
                        .isPeriodic = true};
  sets[4] = (ctTermSet){.kind = ctExpressionTerm,
                        .count = PAIRS,
                        .particlesPerTerm = 2,
                        .particles = &m->pairs[0][0],
                        .expression = &squareExpression,
                        .isPeriodic = true};
  sets[5] = sets[4];
  sets[5].isPeriodic = false;
  sets[6] = (ctTermSet){.kind = ctExpressionTerm,
                        .count = PARTICLES,
                        .particlesPerTerm = 1,
                        .particles = m->all,
                        .parametersPerTerm = 2,
                        .parameters = &m->places[0][0],
                        .expression = &placeExpression,
                        .isPeriodic = true};
  sets[7] = sets[6];
  sets[7].isPeriodic = false;
  sets[8] = (ctTermSet){.kind = ctCentroidTerm,
                        .count = PAIRS,
                        .particlesPerTerm = 4,
                        .particles = &m->groups[0][0],
                        .parametersPerTerm = 4,
                        .parameters = &m->weights[0][0],
                        .expression = &squareExpression,
                        .groupsPerTerm = 2,
                        .isPeriodic = true};
  return (ctEnergyDefinition){.scene = scene,
                              .nonbonded = nonbonded,
                              .pairSetCount = 1,
                              .pairSets = pairSet,
                              .termSetCount = SETS,
                              .termSets = sets,
                              .valueEnergyCount = 1,
                              .valueEnergies = values};
}

static void checkEnergies(const ctEnergy* energy, const Energies* expected) {
  note(ctGetPairEnergy(energy));
  note(ctGetPairSetEnergy(energy, 0));
  CHECK_NEAR(ctGetPairEnergy(energy), expected->value[0], 1e-4 + 3e-6 * expected->size);
  CHECK_NEAR(ctGetPairSetEnergy(energy, 0), expected->value[1], 1e-5);
  for (int s = 0; s < SETS; s++) {
    note(ctGetTermEnergy(energy, s));
    CHECK_NEAR(ctGetTermEnergy(energy, s), expected->value[2 + s], 1e-8);
  }
}

/* Molecules that have drifted by several boxes have the energies of their images. */
static void checkDrift(const Model* m, ctChainTree* tree, ctEnergy* energy, const double (*box)[3]) {
  static double positions[3 * PARTICLES];
  double ofValues;
  double size;
  ctGetPositions(tree, positions);
  for (int i = 0; i < 3 * PARTICLES; i++) {
    const int chain = i / 3 / BEADS;
    positions[i] += 2 * chain * box[0][i % 3] - 3 * chain * box[1][i % 3] + chain * box[2][i % 3];
  }
  CHECK_SUCCESS(ctSetPositions(tree, positions));
  const double expected = computeValueEnergy(m, box, positions, &size);
  CHECK(ctComputeValueEnergies(energy, false, &ofValues) == ctSuccess);
  CHECK_NEAR(ofValues, expected, 1e-6 * size);
}

/* Proposes turns of joints, and motions of molecules. */
static void proposeChanges(const Model* m, ctChainTree* tree, int trial) {
  ctChange changes[2] = {{0}};
  const int changeCount = 1 + (drawn() < 0.3);
  for (int c = 0; c < changeCount; c++) {
    changes[c].link = trial % 4 == 0 ? LINKS - 1 - c * BEADS : ((int)(drawn() * (LINKS / 2)) * 2 + c) % LINKS;
    const bool turns = m->scene.joints[changes[c].link] != ctFreeJoint || drawn() < 0.7;
    for (int d = 0; d < 3; d++) {
      changes[c].rotation[d] = turns ? drawnBetween(-2, 2) : 0;
      changes[c].translation[d] = drawnBetween(-4, 4);
      changes[c].pivot[d] = drawnBetween(0, 3);
    }
  }
  CHECK_SUCCESS(ctPropose(tree, changeCount, changes));
}

/* Displaces up to four particles, neighbours or any. */
static void proposeDisplacements(ctChainTree* tree) {
  ctDisplacement displacements[4];
  const int count = 1 + (int)(4 * drawn());
  const int first = (int)(PARTICLES * drawn());
  const int step = drawn() < 0.5 ? 1 : 17;
  for (int i = 0; i < count; i++) {
    displacements[i].particle = (first + i * step) % PARTICLES;
    for (int d = 0; d < 3; d++) {
      displacements[i].shift[d] = i == 2 ? displacements[0].shift[d] : drawnBetween(-0.2, 0.2);
    }
  }
  CHECK_SUCCESS(ctProposeDisplacements(tree, count, displacements));
}

/* Alpha of Ewald summation times the cutoff; 0: a reaction field instead. */
static double reach;

static bool isFlexible;

static void testBox(const double (*box)[3]) {
  static Model model;
  static double positions[3 * PARTICLES];
  ctNonbonded nonbonded;
  ctPairSet pairSet;
  ctInteractionGroup group;
  ctTermSet sets[SETS];
  ctValueEnergy values;
  char text[200];
  ctDefinition scene = describeScene(&model.scene, box, 0.1);
  fillModel(&model, fmin(fmin(box[0][0], box[1][1]), box[2][2]));
  scene.listed = model.listed;
  scene.isFlexible = isFlexible;
  const ctEnergyDefinition definition = describeEnergy(&model, &scene, &nonbonded, &pairSet, &group, sets, &values);
  nonbonded.ewaldAlpha = reach / model.cutoff;
  nonbonded.switchingDistance = reach == 2.5 ? INFINITY : nonbonded.switchingDistance;
  ctChainTree* tree = checkedCreate(&scene);
  ctEnergy* energy;
  CHECK(ctCreateEnergy(tree, &definition, &energy, text, sizeof text) == ctSuccess);
  CHECK(ctRefreshEnergy(energy, NULL) == ctSuccess);
  Energies before;
  Energies after;
  ctGetPositions(tree, positions);
  computeEnergies(&model, &definition, box, positions, &before);
  checkEnergies(energy, &before);
  for (int t = 0; t < TRIALS; t++) {
    double change = 0;
    if (isFlexible && t % 3 != 0) {
      proposeDisplacements(tree);
    } else {
      proposeChanges(&model, tree, t);
    }
    for (int part = 0; part < CT_ENERGY_PARTS; part++) {
      double ofPart = NAN;
      CHECK(ctComputeEnergyChange(energy, (ctEnergyPart)part, &ofPart, NULL) == ctSuccess);
      change += ofPart;
    }
    CHECK_SUCCESS(ctGetTrialPositions(tree, positions));
    computeEnergies(&model, &definition, box, positions, &after);
    double expected = 0;
    for (int e = 0; e < 2 + SETS; e++) {
      expected += after.value[e] - before.value[e];
    }
    note(change);
    CHECK_NEAR(change, expected, 1e-4 + 3e-6 * (before.size + after.size));
    double ofValues;
    double size;
    const double expectedOfValues = computeValueEnergy(&model, box, positions, &size);
    CHECK(ctComputeValueEnergies(energy, true, &ofValues) == ctSuccess);
    note(ofValues);
    CHECK_NEAR(ofValues, expectedOfValues, 1e-6 * size);
    if (drawn() < 0.6) {
      double ofState;
      CHECK_SUCCESS(ctAccept(tree, NULL));
      CHECK(ctAcceptEnergyChange(energy) == ctSuccess);
      CHECK(ctComputeValueEnergies(energy, false, &ofState) == ctSuccess && ofState == ofValues);
      before = after;
    }
    checkEnergies(energy, &before);
  }
  checkDrift(&model, tree, energy, box);
  ctDestroyEnergy(energy);
  ctDestroy(tree);
}

/* A box that is too narrow for a cutoff. */
static void testNarrowBox(void) {
  static Model model;
  static const double narrow[3][3] = {{4, 0, 0}, {0, 5, 0}, {0, 0, 5}};
  ctNonbonded nonbonded;
  ctPairSet pairSet;
  ctInteractionGroup group;
  ctTermSet sets[SETS];
  ctValueEnergy values;
  char text[200];
  ctDefinition scene = describeScene(&model.scene, boxes[0], 0.1);
  fillModel(&model, 5);
  scene.listed = model.listed;
  const ctEnergyDefinition definition = describeEnergy(&model, &scene, &nonbonded, &pairSet, &group, sets, &values);
  ctChainTree* tree = checkedCreate(&scene);
  ctEnergy* energy;
  CHECK(ctCreateEnergy(tree, &definition, &energy, text, sizeof text) == ctSuccess);
  CHECK(ctRefreshEnergy(energy, NULL) == ctSuccess);
  CHECK_SUCCESS(ctSetBox(tree, narrow));
  CHECK(!ctIsEnergyOfState(energy));
  CHECK(ctRefreshEnergy(energy, NULL) == ctInvalidArgument);
  CHECK(strstr(ctGetEnergyErrorText(energy), "half the periodic box's width, 2 nm") != NULL);
  double ofValues;
  CHECK(ctComputeValueEnergies(energy, false, &ofValues) == ctInvalidArgument);
  CHECK(strstr(ctGetEnergyErrorText(energy), "of value energy 0 is 2.5 nm; it must be at most half") != NULL);
  ctDestroyEnergy(energy);
  ctDestroy(tree);
}

int main(void) {
  testNarrowBox();
  for (int box = 0; box < BOXES; box++) {
    for (int n = 0; n < 5; n++) {
      reach = ((const double[]){0, 2.5, 4, 0, 2.5})[n];
      isFlexible = n >= 3;
      checkInstructionSets(testBox, boxes[box], 1 + (uint32_t)box);
    }
  }
  return checkResult();
}
