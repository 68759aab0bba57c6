/* Each argument of each call on an energy, and each field of its description, at each forbidden value, and at the
 * ends of the allowed range: the status is the one that ctenergy.h says, and energies are as before. */
#include "../../chaintree/tests/borders.h"
#include "../../chaintree/tests/check.h"
#include "ctenergy.h"

enum { BEADS = 20, LINKS = BEADS - 3, MOST_SETS = 8 };

static const int wrongIndices[] = {INT_MIN, -2, -1, BEADS, BEADS + 1, INT_MAX};
static const double smallAndLarge[] = {5e-324, 1e-310, 1e-40, 1e-20, 1e-3, 1e9, 1e15, 1e17, 1e19, 1e30, 1e200, 1.7e308};

/* ---- The description ---- */

static double positions[3 * BEADS];
static double radii[BEADS];
static int links[BEADS];
static int parents[LINKS];
static uint8_t joints[LINKS];
static uint8_t listed[BEADS];
static int torsions[LINKS][4];
static ctDefinition scene;

static double charges[BEADS];
static double sigmas[BEADS];
static double epsilons[BEADS];
static int exclusions[2][2];
static ctNonbonded nonbonded;

static double bornRadii[BEADS];
static double offsetRadii[BEADS];
static double scaledRadii[BEADS];
static double alphas[BEADS];
static int neckTypes[BEADS];
static double neckHeights[4];
static double neckDistances[4];
static ctBorn born;
static ctStandIn standIn;

static int chosen[8];
static double parameters[MOST_SETS][6];
static double coefficients[16];
static ctTorsionMap map;
static ctInput input;
static ctOperation operations[3];
static ctExpression expression;
static ctTermSet termSets[MOST_SETS];

static double kinds[BEADS];
static double heights[4];
static ctTable tables[2];
static ctOperation pairOperations[5];
static ctInteractionGroup group;
static ctPairSet pairSet;

static ctOperation squareOfValue[2];
static ctValueExpression value;
static ctValueExpression term;
static ctValueEnergy valueEnergy;
static ctEnergyDefinition definition;
static bool hasBorn = true;

static void describeScene(void) {
  for (int i = 0; i < BEADS; i++) {
    positions[3 * i] = 0.1 * i;
    positions[3 * i + 1] = i % 4 < 2 ? 0.1 : 0;
    positions[3 * i + 2] = (i + 1) % 4 < 2 ? 0.1 : 0;
    links[i] = i < 3 ? 0 : i - 2 < LINKS ? i - 2 : LINKS - 1;
    listed[i] = 1;
  }
  for (int link = 0; link < LINKS; link++) {
    parents[link] = link - 1;
    joints[link] = (uint8_t)(link == 0 ? ctFreeJoint : ctTorsionJoint);
    for (int k = 0; k < 4; k++) {
      torsions[link][k] = link + k;
    }
  }
  scene = (ctDefinition){.particleCount = BEADS,
                         .positions = positions,
                         .radii = radii,
                         .particleLinks = links,
                         .listed = listed,
                         .linkCount = LINKS,
                         .linkParents = parents,
                         .linkJoints = joints,
                         .linkTorsions = (const int(*)[4])torsions};
}

static void describePairs(void) {
  for (int i = 0; i < BEADS; i++) {
    charges[i] = i % 2 == 0 ? 0.3 : -0.3;
    sigmas[i] = 0.1;
    epsilons[i] = 0.2;
    bornRadii[i] = 0.15;
    offsetRadii[i] = 0.14;
    scaledRadii[i] = 0.08;
    alphas[i] = 1;
    neckTypes[i] = i % 2;
  }
  for (int i = 0; i < 4; i++) {
    exclusions[i / 2][i % 2] = i;
    neckHeights[i] = 0.1;
    neckDistances[i] = 0.3;
  }
  nonbonded = (ctNonbonded){.charges = charges,
                            .sigmas = sigmas,
                            .epsilons = epsilons,
                            .cutoff = 1.8,
                            .switchingDistance = 1.5,
                            .dielectric = 78,
                            .exclusionCount = 2,
                            .exclusions = (const int(*)[2])exclusions};
  born = (ctBorn){.charges = charges,
                  .radii = bornRadii,
                  .offsetRadii = offsetRadii,
                  .scaledRadii = scaledRadii,
                  .isRescaled = true,
                  .alphas = alphas,
                  .betas = alphas,
                  .gammas = alphas,
                  .neckTypeCount = 2,
                  .neckTypes = neckTypes,
                  .neckHeights = neckHeights,
                  .neckDistances = neckDistances,
                  .neckScale = 0.8,
                  .neckCut = 0.2,
                  .coulomb = 138.9,
                  .soluteDielectric = 1,
                  .solventDielectric = 78.5,
                  .kappa = 0.7,
                  .surfaceEnergy = 28.4,
                  .probeRadius = 0.14,
                  .cutoff = 2,
                  .shift = 0.1};
  standIn = (ctStandIn){.bornCutoff = 0.8, .pairCutoff = 0.9, .gridWidth = 0.05};
}

static void describeTerms(void) {
  static const int widths[MOST_SETS] = {2, 3, 4, 4, 8, 2, 2, 4};
  static const int counts[MOST_SETS] = {2, 2, 3, 6, 1, 3, 1, 5};
  for (int i = 0; i < 8; i++) {
    chosen[i] = i + 2;
  }
  for (int i = 0; i < 16; i++) {
    coefficients[i] = i;
  }
  map = (ctTorsionMap){1, coefficients};
  input = (ctInput){ctMeasureDistance, {0, 1, 0, 0}};
  operations[0] = (ctOperation){ctInputOperator, {0}, 0};
  operations[1] = (ctOperation){ctParameterOperator, {0}, 0};
  operations[2] = (ctOperation){ctMultiplyOperator, {0, 1}, 0};
  expression = (ctExpression){1, &input, 3, operations};
  for (int s = 0; s < MOST_SETS; s++) {
    for (int p = 0; p < 6; p++) {
      parameters[s][p] = s == 4 ? 0 : p + 1;
    }
    termSets[s] = (ctTermSet){.kind = (ctTermKind)s,
                              .count = 1,
                              .particlesPerTerm = widths[s],
                              .particles = chosen,
                              .parametersPerTerm = counts[s],
                              .parameters = parameters[s],
                              .mapCount = s == 4,
                              .maps = &map,
                              .expression = &expression,
                              .groupsPerTerm = 2};
  }
}

/* c(kind of one bead, kind of the other) f(r), with one table of each sort. */
static void describeExpressions(void) {
  for (int i = 0; i < BEADS; i++) {
    kinds[i] = i % 2;
  }
  for (int i = 0; i < 4; i++) {
    heights[i] = 0.1 * (i % 3);
  }
  heights[1] = heights[2];
  tables[0] = (ctTable){.isDiscrete = true, .dimensions = 2, .sizes = {2, 2, 1}, .values = heights};
  tables[1] = (ctTable){.dimensions = 1, .sizes = {1, 1, 1}, .maxima = {2, 1, 1}, .values = heights};
  pairOperations[0] = (ctOperation){ctInputOperator, {0}, 0};
  pairOperations[1] = (ctOperation){ctParameterOperator, {0}, 0};
  pairOperations[2] = (ctOperation){ctParameterOperator, {1}, 0};
  pairOperations[3] = (ctOperation){ctTableOperator, {1, 2}, 0};
  pairOperations[4] = (ctOperation){ctTableOperator, {0}, 1};
  static int first[] = {0, 2, 4};
  static int second[] = {1, 3, 5, 7};
  group = (ctInteractionGroup){.counts = {3, 4}, .particles = {first, second}};
  pairSet = (ctPairSet){.operationCount = 5,
                        .operations = pairOperations,
                        .tableCount = 2,
                        .tables = tables,
                        .parametersPerParticle = 1,
                        .parameters = kinds,
                        .cutoff = 1.2,
                        .switchingDistance = 1,
                        .exclusionCount = 2,
                        .exclusions = (const int(*)[2])exclusions,
                        .groupCount = 1,
                        .groups = &group};
  squareOfValue[0] = (ctOperation){ctParameterOperator, {1}, 0};
  squareOfValue[1] = (ctOperation){ctSquareOperator, {0}, 0};
  /* In values, parameter 2 is the kind of the other bead. */
  static ctOperation valueOperations[5];
  memcpy(valueOperations, pairOperations, sizeof valueOperations);
  valueOperations[2].arguments[0] = 2;
  value = (ctValueExpression){ctOfPairs, 5, valueOperations, 2, tables};
  term = (ctValueExpression){.extent = ctOfParticles, .operationCount = 2, .operations = squareOfValue};
  valueEnergy = (ctValueEnergy){.parametersPerParticle = 1,
                                .parameters = kinds,
                                .valueCount = 1,
                                .values = &value,
                                .termCount = 1,
                                .terms = &term,
                                .cutoff = 1.2,
                                .exclusionCount = 2,
                                .exclusions = (const int(*)[2])exclusions};
}

static void describe(void) {
  describeScene();
  describePairs();
  describeTerms();
  describeExpressions();
  definition = (ctEnergyDefinition){.scene = &scene,
                                    .nonbonded = &nonbonded,
                                    .born = hasBorn ? &born : NULL,
                                    .standIn = &standIn,
                                    .pairSetCount = 1,
                                    .pairSets = &pairSet,
                                    .termSetCount = MOST_SETS,
                                    .termSets = termSets,
                                    .valueEnergyCount = 1,
                                    .valueEnergies = &valueEnergy};
}

/* ---- Creation ---- */

static ctChainTree* tree;

static void checkRefused(int line, const char* name) {
  ctEnergy* energy = (ctEnergy*)positions; /* anything but NULL */
  char text[200] = "";
  callCount++;
  const ctStatus status = ctCreateEnergy(tree, &definition, &energy, text, sizeof text);
  if (status != ctInvalidArgument || energy != NULL || text[0] == '\0') {
    reportFailure("line %d: %s was not refused, or without a reason\n", line, name);
    if (status == ctSuccess) {
      ctDestroyEnergy(energy);
    }
  }
}

/* What is right can be computed, whatever comes of it. */
static void checkTaken(int line, const char* name) {
  ctEnergy* energy;
  char text[200] = "";
  double numbers[2] = {0};
  const ctStatus status = ctCreateEnergy(tree, &definition, &energy, text, sizeof text);
  callCount++;
  if (status != ctSuccess) {
    reportFailure("line %d: %s was refused: %s\n", line, name, text);
    return;
  }
  CHECK_SUCCESS(ctRefreshEnergy(energy, NULL));
  CHECK_SUCCESS(ctPropose(tree, 1, &(ctChange){.link = 7, .angle = 0.5}));
  for (int part = 0; part < CT_ENERGY_PARTS; part++) {
    CHECK_SUCCESS(ctComputeEnergyChange(energy, (ctEnergyPart)part, numbers, NULL));
  }
  CHECK_SUCCESS(ctComputeValueEnergies(energy, true, numbers));
  ctReject(tree);
  CHECK_SUCCESS(ctComputeWholeEnergy(energy, &numbers[0], &numbers[1], NULL));
  CHECK_SUCCESS(ctRenewStandIn(energy, NULL));
  ctDestroyEnergy(energy);
}

/* Refuses an int at these values; it is right again afterwards. */
#define REFUSE_INTS(field, values)  \
  for (EACH(i_, values)) {          \
    (field) = (values)[i_];         \
    checkRefused(__LINE__, #field); \
    describe();                     \
  }

#define REFUSE_NUMBERS(field, values) REFUSE_INTS(field, values)

#define REFUSE_NULL(field)          \
  do {                              \
    (field) = NULL;                 \
    checkRefused(__LINE__, #field); \
    describe();                     \
  } while (0)

#define TAKE_NUMBERS(field, values) \
  for (EACH(i_, values)) {          \
    (field) = (values)[i_];         \
    checkTaken(__LINE__, #field);   \
    describe();                     \
  }

static void testWhole(void) {
  ctEnergy* energy = (ctEnergy*)positions;
  CHECK(ctCreateEnergy(NULL, &definition, &energy, NULL, 0) == ctInvalidArgument && energy == NULL);
  CHECK(ctCreateEnergy(tree, NULL, &energy, NULL, 0) == ctInvalidArgument);
  CHECK(ctCreateEnergy(tree, &definition, NULL, NULL, 0) == ctInvalidArgument);
  checkTaken(__LINE__, "the description");
  REFUSE_NULL(definition.scene);
  REFUSE_NULL(definition.nonbonded); /* since there is born */
  REFUSE_NULL(definition.standIn);
  REFUSE_NULL(definition.pairSets);
  REFUSE_NULL(definition.termSets);
  REFUSE_NULL(definition.valueEnergies);
  REFUSE_INTS(definition.pairSetCount, wrongCounts);
  REFUSE_INTS(definition.termSetCount, wrongCounts);
  REFUSE_INTS(definition.valueEnergyCount, wrongCounts);
  /* Another scene than that of the tree. */
  const int others[] = {INT_MIN, -1, 0, BEADS - 1, BEADS + 1, INT_MAX};
  REFUSE_INTS(scene.particleCount, others);
  REFUSE_INTS(scene.linkCount, others);
  REFUSE_INTS(links[4], wrongIndices);
  const int cycles[] = {INT_MIN, -2, 3, 5, 16, INT_MAX}; /* links that hang on themselves, or on each other */
  REFUSE_INTS(parents[3], cycles);
  REFUSE_NULL(scene.linkParents);
  REFUSE_NULL(scene.linkJoints);
  REFUSE_NULL(scene.particleLinks);
  REFUSE_NULL(scene.linkTorsions);
}

/* Alone, and as a part of the energy that a stand-in replaces. */
static void testNonbonded(void) {
  REFUSE_NULL(nonbonded.charges);
  REFUSE_NULL(nonbonded.sigmas);
  REFUSE_NULL(nonbonded.epsilons);
  REFUSE_NULL(nonbonded.exclusions);
  REFUSE_INTS(nonbonded.exclusionCount, wrongCounts);
  REFUSE_INTS(exclusions[1][0], wrongIndices);
  REFUSE_INTS(exclusions[0][1], wrongIndices);
  REFUSE_NUMBERS(charges[BEADS - 1], notFinite);
  REFUSE_NUMBERS(sigmas[0], notFinite);
  REFUSE_NUMBERS(epsilons[7], notFinite);
  REFUSE_NUMBERS(epsilons[7], ((const double[]){-5e-324, -1}));
  REFUSE_NUMBERS(nonbonded.cutoff, notPositive);
  REFUSE_NUMBERS(nonbonded.cutoff, ((const double[]){5e-324, 1e-200})); /* a reaction field beyond floats */
  REFUSE_NUMBERS(nonbonded.switchingDistance, ((const double[]){NAN, -INFINITY, -1}));
  REFUSE_NUMBERS(nonbonded.dielectric, notFinite);
  REFUSE_NUMBERS(nonbonded.dielectric, ((const double[]){-0.5}));
  REFUSE_NUMBERS(nonbonded.ewaldAlpha, notFinite);
  REFUSE_NUMBERS(nonbonded.ewaldAlpha, ((const double[]){-5e-324, -1, 6.001 / 1.8}));
  const double ewaldAlphas[] = {5e-324, 1e-40, 2.5, 5.999 / 1.8};
  for (EACH(i, ewaldAlphas)) {
    nonbonded.ewaldAlpha = ewaldAlphas[i];
    if (hasBorn) {
      checkRefused(__LINE__, "nonbonded.ewaldAlpha");
    } else {
      checkTaken(__LINE__, "nonbonded.ewaldAlpha");
    }
    describe();
  }
  const double largeCutoffs[] = {1e9, 1e15, 1e17, 1e19, 1e30, 1e200, 1.7e308, INFINITY};
  TAKE_NUMBERS(nonbonded.cutoff, largeCutoffs);
  const double switches[] = {0, 5e-324, 1.7, 1.8, 1e300, INFINITY};
  TAKE_NUMBERS(nonbonded.switchingDistance, switches);
  TAKE_NUMBERS(charges[3], smallAndLarge);
  TAKE_NUMBERS(sigmas[3], smallAndLarge);
  TAKE_NUMBERS(epsilons[3], smallAndLarge);
}

static void testBorn(void) {
  REFUSE_NULL(born.charges);
  REFUSE_NULL(born.radii);
  REFUSE_NULL(born.offsetRadii);
  REFUSE_NULL(born.scaledRadii);
  REFUSE_NULL(born.alphas);
  REFUSE_NULL(born.betas);
  REFUSE_NULL(born.gammas);
  REFUSE_NULL(born.neckTypes);
  REFUSE_NULL(born.neckHeights);
  REFUSE_NULL(born.neckDistances);
  REFUSE_INTS(born.neckTypeCount, wrongCounts);
  REFUSE_INTS(born.neckTypeCount,
              ((const int[]){1, 23171, 46341, 65536})); /* squares that are too large; type 1 is none */
  REFUSE_INTS(neckTypes[5], wrongIndices);
  REFUSE_NUMBERS(neckHeights[3], notFinite);
  REFUSE_NUMBERS(neckDistances[0], notFinite);
  REFUSE_NUMBERS(bornRadii[2], notPositive);
  REFUSE_NUMBERS(bornRadii[2], notFinite);
  REFUSE_NUMBERS(offsetRadii[2], notPositive);
  REFUSE_NUMBERS(offsetRadii[2], notFinite);
  REFUSE_NUMBERS(scaledRadii[2], notFinite);
  REFUSE_NUMBERS(alphas[2], notFinite);
  REFUSE_NUMBERS(born.neckScale, notFinite);
  REFUSE_NUMBERS(born.neckCut, notFinite);
  REFUSE_NUMBERS(born.coulomb, notFinite);
  REFUSE_NUMBERS(born.coulomb, ((const double[]){-1}));
  REFUSE_NUMBERS(born.soluteDielectric, notPositive);
  REFUSE_NUMBERS(born.solventDielectric, notFinite);
  REFUSE_NUMBERS(born.kappa, notFinite);
  REFUSE_NUMBERS(born.kappa, ((const double[]){-1}));
  REFUSE_NUMBERS(born.surfaceEnergy, notFinite);
  REFUSE_NUMBERS(born.probeRadius, notFinite);
  REFUSE_NUMBERS(born.shift, notFinite);
  REFUSE_NUMBERS(born.cutoff, notPositive);
  double* numbers[] = {&bornRadii[2],
                       &offsetRadii[2],
                       &scaledRadii[2],
                       &alphas[2],
                       &born.neckScale,
                       &born.neckCut,
                       &born.coulomb,
                       &born.soluteDielectric,
                       &born.solventDielectric,
                       &born.kappa,
                       &born.surfaceEnergy,
                       &born.probeRadius,
                       &born.shift,
                       &born.cutoff};
  for (EACH(n, numbers)) {
    TAKE_NUMBERS(*numbers[n], smallAndLarge);
  }
  born.neckTypeCount = 0; /* what is not read may be missing */
  born.neckTypes = NULL;
  born.neckHeights = born.neckDistances = NULL;
  born.neckScale = NAN;
  born.isRescaled = false;
  born.alphas = born.betas = born.gammas = NULL;
  checkTaken(__LINE__, "necks that are not read");
  describe();
  const double wrongCutoffs[] = {NAN, INFINITY, -1, 0, 5e-324, 1e-300, 9e-4, 1.1e15, 1e300};
  REFUSE_NUMBERS(standIn.bornCutoff, wrongCutoffs);
  REFUSE_NUMBERS(standIn.pairCutoff, wrongCutoffs);
  REFUSE_NUMBERS(standIn.gridWidth, ((const double[]){NAN, INFINITY, -1, 0, 9e-5, 1.1}));
  TAKE_NUMBERS(standIn.bornCutoff, ((const double[]){1e-3, 1e15}));
  TAKE_NUMBERS(standIn.pairCutoff, ((const double[]){1e-3, 1e15}));
  TAKE_NUMBERS(standIn.gridWidth, ((const double[]){1e-4, 1}));
}

static void testTerms(void) {
  for (int s = 0; s < MOST_SETS; s++) {
    ctTermSet* set = &termSets[s];
    REFUSE_NULL(set->particles);
    REFUSE_NULL(set->parameters);
    REFUSE_INTS(set->count, wrongCounts);
    REFUSE_INTS(set->particlesPerTerm, wrongCounts);
    REFUSE_INTS(set->parametersPerTerm, wrongCounts);
    REFUSE_INTS(set->mapCount, wrongCounts);
    REFUSE_INTS(*(int*)&set->kind, ((const int[]){INT_MIN, -1, MOST_SETS, INT_MAX}));
    if (s < ctExpressionTerm) {
      REFUSE_INTS(set->particlesPerTerm, ((const int[]){0, 1, 9}));
      REFUSE_INTS(set->parametersPerTerm, ((const int[]){0, 7}));
      REFUSE_NUMBERS(parameters[s][0], notFinite);
      REFUSE_NUMBERS(parameters[s][set->parametersPerTerm - 1], notFinite);
    } else {
      TAKE_NUMBERS(parameters[s][0], notFinite);
    }
    if (s != ctPeriodicTorsionTerm && s != ctTorsionMapTerm) {
      TAKE_NUMBERS(parameters[s][0], smallAndLarge);
    }
  }
  REFUSE_INTS(chosen[1], wrongIndices);
  REFUSE_NUMBERS(parameters[ctPeriodicTorsionTerm][0], ((const double[]){-1, 0.5, 5e-324, 2147483647, 1e300}));
  REFUSE_NUMBERS(parameters[ctTorsionMapTerm][0], ((const double[]){-1, 0.5, 5e-324, 1, 1e300}));
  REFUSE_NULL(termSets[ctTorsionMapTerm].maps);
  REFUSE_NULL(map.coefficients);
  REFUSE_INTS(map.size, wrongCounts);
  REFUSE_INTS(map.size, ((const int[]){0, 5793, 46341, 1 << 28, 1 << 30}));
  REFUSE_NUMBERS(coefficients[15], notFinite);
}

static void testCentroids(void) {
  ctTermSet* set = &termSets[ctCentroidTerm];
  REFUSE_INTS(set->groupsPerTerm, ((const int[]){INT_MIN, -1, 0, 1, 3, 8, INT_MAX}));
  REFUSE_INTS(set->particlesPerTerm, ((const int[]){0, 1, 3, 6}));
  REFUSE_INTS(set->parametersPerTerm, ((const int[]){0, 3}));
  REFUSE_NULL(set->expression);
}

static void testExpressions(void) {
  REFUSE_NULL(termSets[ctExpressionTerm].expression);
  REFUSE_NULL(expression.inputs);
  REFUSE_NULL(expression.operations);
  REFUSE_INTS(expression.inputCount, wrongCounts);
  REFUSE_INTS(expression.operationCount, wrongCounts);
  REFUSE_INTS(expression.operationCount, ((const int[]){0, CT_MOST_OPERATIONS + 1}));
  REFUSE_INTS(*(int*)&input.measure, ((const int[]){INT_MIN, -1, ctMeasureDihedral + 1, INT_MAX}));
  REFUSE_INTS(input.particles[1], ((const int[]){INT_MIN, -1, 2, INT_MAX}));
  REFUSE_INTS(*(int*)&operations[2].kind, ((const int[]){INT_MIN, -1, ctTableOperator, ctTableOperator + 1, INT_MAX}));
  const int notEarlier[] = {INT_MIN, -1, 2, 3, INT_MAX};
  REFUSE_INTS(operations[2].arguments[0], notEarlier);
  REFUSE_INTS(operations[2].arguments[1], notEarlier);
  REFUSE_INTS(operations[0].arguments[0], ((const int[]){INT_MIN, -1, 1, INT_MAX}));
  REFUSE_INTS(operations[1].arguments[0], ((const int[]){INT_MIN, -1, 1, INT_MAX}));
  TAKE_NUMBERS(operations[2].constant, notFinite);
  /* Every operator on every pair of extremes. */
  for (int kind = ctConstantOperator; kind <= ctSelectOperator; kind++) {
    for (EACH(i, smallAndLarge)) {
      operations[0] = (ctOperation){ctConstantOperator, {-7, 7, -7}, i % 2 == 0 ? smallAndLarge[i] : -smallAndLarge[i]};
      parameters[ctExpressionTerm][0] = i < 3 ? notFinite[i] : smallAndLarge[i];
      operations[2] = (ctOperation){(ctOperator)kind, {0, 1, 0}, smallAndLarge[i]};
      if (kind == ctInputOperator || kind == ctParameterOperator) {
        operations[2].arguments[0] = 0;
      }
      checkTaken(__LINE__, "an operator");
      describe();
    }
  }
}

static void testPairSets(void) {
  REFUSE_NULL(pairSet.operations);
  REFUSE_NULL(pairSet.tables);
  REFUSE_NULL(pairSet.parameters);
  REFUSE_NULL(pairSet.exclusions);
  REFUSE_NULL(pairSet.groups);
  REFUSE_NULL(group.particles[1]);
  REFUSE_INTS(pairSet.operationCount, wrongCounts);
  REFUSE_INTS(pairSet.operationCount, ((const int[]){0, CT_MOST_OPERATIONS + 1}));
  REFUSE_INTS(pairSet.tableCount, wrongCounts);
  REFUSE_INTS(pairSet.parametersPerParticle, wrongCounts);
  REFUSE_INTS(pairSet.parametersPerParticle, ((const int[]){0, CT_MOST_COUNT, CT_MOST_COUNT / BEADS + 1}));
  REFUSE_INTS(pairSet.exclusionCount, wrongCounts);
  REFUSE_INTS(pairSet.groupCount, wrongCounts);
  REFUSE_INTS(group.counts[0], wrongCounts);
  REFUSE_INTS(exclusions[0][0], wrongIndices);
  REFUSE_INTS(((int*)group.particles[0])[2], wrongIndices);
  ((int*)group.particles[0])[2] = 4;
  REFUSE_NUMBERS(kinds[5], notFinite);
  REFUSE_NUMBERS(pairSet.cutoff, notPositive);
  REFUSE_NUMBERS(pairSet.switchingDistance, ((const double[]){NAN, -INFINITY}));
  const int notEarlier[] = {INT_MIN, -1, 3, INT_MAX};
  REFUSE_INTS(pairOperations[3].arguments[1], notEarlier);
  REFUSE_INTS(*(int*)&pairOperations[3].kind,
              ((const int[]){INT_MIN, -1, ctImageLengthOperator, ctTableOperator + 1, INT_MAX}));
  REFUSE_INTS(pairOperations[0].arguments[0], ((const int[]){INT_MIN, -1, 1, INT_MAX}));
  REFUSE_INTS(pairOperations[1].arguments[0], ((const int[]){INT_MIN, -1, 2, INT_MAX}));
  REFUSE_NUMBERS(pairOperations[3].constant,
                 ((const double[]){NAN, INFINITY, -INFINITY, -1, 0.5, 2, 2147483648.0, 1e300}));
  TAKE_NUMBERS(pairSet.cutoff, smallAndLarge);
  TAKE_NUMBERS(pairSet.cutoff, ((const double[]){INFINITY}));
  TAKE_NUMBERS(pairSet.switchingDistance, ((const double[]){-1, 0, 1.1999, 1.2, 1e300, INFINITY}));
  TAKE_NUMBERS(kinds[5], smallAndLarge);
}

static void testTables(void) {
  for (int t = 0; t < 2; t++) {
    REFUSE_NULL(tables[t].values);
    REFUSE_INTS(tables[t].dimensions, ((const int[]){INT_MIN, -1, 0, 4, INT_MAX}));
    REFUSE_INTS(tables[t].sizes[0], wrongCounts);
    REFUSE_INTS(tables[t].sizes[0], ((const int[]){0, CT_MOST_COUNT}));
  }
  tables[0].dimensions = 3; /* products that no size_t holds */
  tables[0].sizes[0] = tables[0].sizes[1] = tables[0].sizes[2] = 1 << 22;
  checkRefused(__LINE__, "sizes of a table");
  describe();
  tables[1].dimensions = 3;
  checkRefused(__LINE__, "dimensions of a table");
  describe();
  REFUSE_NUMBERS(tables[1].minima[0], ((const double[]){NAN, INFINITY, -INFINITY, 2, 3, -1.7e308 * 2}));
  REFUSE_NUMBERS(tables[1].maxima[0], ((const double[]){NAN, INFINITY, -INFINITY, 0, -1}));
  tables[1].minima[0] = -1.7e308;
  tables[1].maxima[0] = 1.7e308;
  checkRefused(__LINE__, "the width of a range");
  describe();
  TAKE_NUMBERS(tables[1].maxima[0], smallAndLarge);
  tables[1].isPeriodic = true;
  checkTaken(__LINE__, "a periodic table");
  describe();
  TAKE_NUMBERS(heights[3], notFinite);
}

static void testValueEnergies(void) {
  REFUSE_NULL(valueEnergy.parameters);
  REFUSE_NULL(valueEnergy.values);
  REFUSE_NULL(valueEnergy.terms);
  REFUSE_NULL(valueEnergy.exclusions);
  REFUSE_NULL(value.operations);
  REFUSE_NULL(value.tables);
  REFUSE_INTS(valueEnergy.parametersPerParticle, wrongCounts);
  REFUSE_INTS(valueEnergy.parametersPerParticle, ((const int[]){CT_MOST_COUNT, CT_MOST_COUNT / BEADS}));
  REFUSE_INTS(valueEnergy.valueCount, wrongCounts);
  REFUSE_INTS(valueEnergy.termCount, wrongCounts);
  REFUSE_INTS(valueEnergy.exclusionCount, wrongCounts);
  REFUSE_INTS(value.operationCount, wrongCounts);
  REFUSE_INTS(value.tableCount, wrongCounts);
  REFUSE_INTS(*(int*)&value.extent, ((const int[]){INT_MIN, -1, 3, INT_MAX}));
  REFUSE_INTS(squareOfValue[0].arguments[0], ((const int[]){INT_MIN, -1, 5, INT_MAX}));
  REFUSE_NUMBERS(valueEnergy.cutoff, notPositive);
  TAKE_NUMBERS(valueEnergy.cutoff, smallAndLarge);
  TAKE_NUMBERS(valueEnergy.cutoff, ((const double[]){INFINITY}));
}

/* ---- Cutoffs that reach everything are as good as none ---- */

static void testReach(void) {
  double expected[2] = {0};
  definition.born = NULL;
  pairSet.switchingDistance = INFINITY;
  for (int i = 0; i < 6; i++) {
    const double cutoffs[] = {INFINITY, 1e16, 1e18, 1e19, 1e25, 1e300};
    double values[1];
    ctEnergy* energy;
    pairSet.cutoff = valueEnergy.cutoff = cutoffs[i];
    CHECK_SUCCESS(ctCreateEnergy(tree, &definition, &energy, NULL, 0));
    CHECK_SUCCESS(ctRefreshEnergy(energy, NULL));
    CHECK_SUCCESS(ctComputeValueEnergies(energy, false, values));
    if (i == 0) {
      expected[0] = ctGetPairSetEnergy(energy, 0);
      expected[1] = values[0];
    }
    CHECK(ctGetPairSetEnergy(energy, 0) == expected[0] && values[0] == expected[1] && expected[0] != 0);
    ctDestroyEnergy(energy);
  }
  describe();
}

/* ---- Calls ---- */

typedef struct Answers {
  double pairs;
  double pairSet;
  double terms[MOST_SETS];
  double values[1];
  double whole[2];
  double constants[BEADS];
  bool isOfState;
} Answers;

static void ask(ctEnergy* energy, Answers* a) {
  memset(a, 0, sizeof *a);
  a->pairs = ctGetPairEnergy(energy);
  a->pairSet = ctGetPairSetEnergy(energy, 0);
  for (int s = 0; s < MOST_SETS; s++) {
    a->terms[s] = ctGetTermEnergy(energy, s);
  }
  CHECK_SUCCESS(ctComputeValueEnergies(energy, false, a->values));
  CHECK_SUCCESS(ctComputeWholeEnergy(energy, &a->whole[0], &a->whole[1], NULL));
  ctGetStandIn(energy, a->constants);
  a->isOfState = ctIsEnergyOfState(energy);
}

static Answers before;

static void checkUnchanged(int line, ctEnergy* energy) {
  Answers now;
  ask(energy, &now);
  callCount++;
  if (memcmp(&now, &before, sizeof now) != 0) {
    reportFailure("line %d: energies have changed\n", line);
  }
}

#define REFUSED(expected, culprit, call)                                                                       \
  do {                                                                                                         \
    const ctStatus status_ = (call);                                                                           \
    if (status_ != (expected) || strstr(ctGetEnergyErrorText(energy), culprit) == NULL) {                      \
      reportFailure("line %d: %s: %d, \"%s\"\n", __LINE__, #call, (int)status_, ctGetEnergyErrorText(energy)); \
    }                                                                                                          \
    checkUnchanged(__LINE__, energy);                                                                          \
  } while (0)

static void testWithoutEnergy(void) {
  double x[BEADS];
  CHECK(ctGetEnergyErrorText(NULL)[0] == '\0' && ctCountChangeableTerms(NULL, 0) == 0 && !ctIsEnergyOfState(NULL));
  CHECK(isnan(ctGetPairEnergy(NULL)) && isnan(ctGetPairSetEnergy(NULL, 0)) && isnan(ctGetTermEnergy(NULL, 0)));
  CHECK(isnan(ctGetNearChangeBack(NULL)));
  CHECK(ctRefreshEnergy(NULL, NULL) == ctInvalidArgument);
  CHECK(ctComputeEnergyChange(NULL, ctTermsPart, x, NULL) == ctInvalidArgument);
  CHECK(ctAcceptEnergyChange(NULL) == ctInvalidArgument);
  CHECK(ctComputeValueEnergies(NULL, false, x) == ctInvalidArgument);
  CHECK(ctComputeWholeEnergy(NULL, x, x + 1, NULL) == ctInvalidArgument);
  CHECK(ctRenewStandIn(NULL, NULL) == ctInvalidArgument);
  CHECK(ctSetStandIn(NULL, x) == ctInvalidArgument);
  CHECK(ctSaveEnergy(NULL) == ctInvalidArgument && ctRestoreEnergy(NULL) == ctInvalidArgument);
  ctGetStandIn(NULL, x);
  ctDestroyEnergy(NULL);
}

static void testIndices(ctEnergy* energy) {
  const int noSets[] = {INT_MIN, -2, -1, MOST_SETS, MOST_SETS + 1, INT_MAX};
  for (EACH(i, noSets)) {
    CHECK(isnan(ctGetTermEnergy(energy, noSets[i])) && ctCountChangeableTerms(energy, noSets[i]) == 0);
    CHECK(isnan(ctGetPairSetEnergy(energy, noSets[i])));
    checkUnchanged(__LINE__, energy);
  }
  CHECK(isnan(ctGetPairSetEnergy(energy, 1)) && !isnan(ctGetPairSetEnergy(energy, 0)));
}

static void testArguments(ctEnergy* energy) {
  double x[BEADS];
  REFUSED(ctInvalidArgument, "energies is NULL", ctComputeValueEnergies(energy, false, NULL));
  REFUSED(ctInvalidArgument, "nonbonded is NULL", ctComputeWholeEnergy(energy, NULL, x, NULL));
  REFUSED(ctInvalidArgument, "born is NULL", ctComputeWholeEnergy(energy, x, NULL, NULL));
  REFUSED(ctInvalidArgument, "change is NULL", ctComputeEnergyChange(energy, ctTermsPart, NULL, NULL));
  REFUSED(ctInvalidArgument, "constants is NULL", ctSetStandIn(energy, NULL));
  ctGetStandIn(energy, NULL);
  for (int i = 0; i < BEADS; i++) {
    const double wrong[] = {NAN, INFINITY, -INFINITY, 1e39, -1.7e308};
    for (EACH(k, wrong)) {
      memcpy(x, before.constants, sizeof x);
      x[i] = wrong[k];
      REFUSED(ctInvalidArgument, "constant of particle", ctSetStandIn(energy, x));
    }
  }
}

/* Calls that come when they must not. */
static void testOrder(ctEnergy* energy) {
  double x[1];
  const int wrongParts[] = {INT_MIN, -1, 1, 2, 3, INT_MAX};
  REFUSED(ctNoTrial, "no open trial", ctComputeValueEnergies(energy, true, x));
  REFUSED(ctInvalidArgument, "no copy", ctRestoreEnergy(energy));
  for (int part = 0; part < CT_ENERGY_PARTS; part++) {
    REFUSED(ctNoTrial, "no open trial", ctComputeEnergyChange(energy, (ctEnergyPart)part, x, NULL));
  }
  REFUSED(ctInvalidArgument, "not all parts", ctAcceptEnergyChange(energy));
  CHECK_SUCCESS(ctPropose(tree, 1, &(ctChange){.link = 7, .angle = 0.5}));
  for (EACH(i, wrongParts)) {
    REFUSED(ctInvalidArgument, "in their order", ctComputeEnergyChange(energy, (ctEnergyPart)wrongParts[i], x, NULL));
    REFUSED(ctInvalidArgument, "not all parts", ctAcceptEnergyChange(energy));
  }
  for (int part = 0; part < CT_ENERGY_PARTS; part++) {
    CHECK_SUCCESS(ctComputeEnergyChange(energy, (ctEnergyPart)part, x, NULL));
    REFUSED(ctInvalidArgument, "not all parts", ctAcceptEnergyChange(energy)); /* nothing is accepted */
  }
  ctReject(tree);
  REFUSED(ctInvalidArgument, "not all parts", ctAcceptEnergyChange(energy));
}

/* A state that somebody has set is not the one to which the trial has led. */
static void testAcceptanceOfAnotherState(ctEnergy* energy) {
  double x[1];
  double now[3 * BEADS];
  double state[3 * BEADS + 7 + LINKS - 1];
  CHECK(ctGetStateSize(tree) == sizeof state / sizeof state[0]);
  ctGetState(tree, state);
  ctGetPositions(tree, now);
  for (int way = 0; way < 3; way++) {
    CHECK_SUCCESS(ctPropose(tree, 1, &(ctChange){.link = 7, .angle = 0.5}));
    for (int part = 0; part < CT_ENERGY_PARTS; part++) {
      CHECK_SUCCESS(ctComputeEnergyChange(energy, (ctEnergyPart)part, x, NULL));
    }
    if (way == 0) {
      CHECK_SUCCESS(ctSetPositions(tree, now));
    } else if (way == 1) {
      CHECK_SUCCESS(ctSetState(tree, state));
    } else {
      CHECK_SUCCESS(ctAccept(tree, NULL));
      CHECK_SUCCESS(ctSetState(tree, state));
    }
    CHECK(ctAcceptEnergyChange(energy) == ctInvalidArgument && !ctIsEnergyOfState(energy));
    CHECK_SUCCESS(ctSetState(tree, state));
    CHECK_SUCCESS(ctRefreshEnergy(energy, NULL));
    checkUnchanged(__LINE__, energy);
  }
}

static void testCalls(void) {
  ctEnergy* energy;
  CHECK_SUCCESS(ctCreateEnergy(tree, &definition, &energy, NULL, 0));
  CHECK(ctGetEnergyErrorText(energy)[0] == '\0' && !ctIsEnergyOfState(energy));
  double x[2];
  CHECK_SUCCESS(ctPropose(tree, 1, &(ctChange){.link = 7, .angle = 0.5}));
  CHECK(ctComputeEnergyChange(energy, ctTermsPart, x, NULL) == ctInvalidArgument); /* nothing was refreshed */
  ctReject(tree);
  CHECK_SUCCESS(ctRenewStandIn(energy, NULL));
  ask(energy, &before);
  testIndices(energy);
  testArguments(energy);
  testOrder(energy);
  testAcceptanceOfAnotherState(energy);
  ctDestroyEnergy(energy);
  /* Without pairs. */
  const ctEnergyDefinition terms = {.scene = &scene, .termSetCount = 1, .termSets = termSets};
  CHECK_SUCCESS(ctCreateEnergy(tree, &terms, &energy, NULL, 0));
  CHECK_SUCCESS(ctRefreshEnergy(energy, NULL));
  CHECK(isnan(ctGetPairSetEnergy(energy, 0)) && ctGetPairEnergy(energy) == 0 && isnan(ctGetTermEnergy(energy, 1)));
  CHECK_SUCCESS(ctSetStandIn(energy, NULL));
  CHECK_SUCCESS(ctRenewStandIn(energy, NULL));
  CHECK_SUCCESS(ctComputeValueEnergies(energy, false, NULL));
  ctDestroyEnergy(energy);
}

/* Particles in one place have no Born sum; the constants do not change. */
static void testNoFarPart(void) {
  double together[3 * BEADS];
  double constants[2][BEADS];
  ctEnergy* energy;
  CHECK_SUCCESS(ctCreateEnergy(tree, &definition, &energy, NULL, 0));
  CHECK_SUCCESS(ctRenewStandIn(energy, NULL));
  ctGetStandIn(energy, constants[0]);
  memcpy(together, positions, sizeof together);
  memcpy(together + 3 * 15, together + 3 * 2, 3 * sizeof(double));
  CHECK_SUCCESS(ctSetPositions(tree, together));
  CHECK_SUCCESS(ctRenewStandIn(energy, NULL));
  ctGetStandIn(energy, constants[1]);
  for (int i = 0; i < BEADS; i++) {
    CHECK(isfinite(constants[1][i]));
  }
  CHECK_SUCCESS(ctSetStandIn(energy, constants[1]));
  CHECK_SUCCESS(ctSetPositions(tree, positions));
  CHECK_SUCCESS(ctRenewStandIn(energy, NULL));
  ctGetStandIn(energy, constants[1]);
  CHECK(memcmp(constants[0], constants[1], sizeof constants[0]) == 0);
  ctDestroyEnergy(energy);
}

int main(void) {
  describe();
  tree = checkedCreate(&scene);
  testWhole();
  testNonbonded();
  hasBorn = false;
  describe();
  testNonbonded();
  hasBorn = true;
  describe();
  testBorn();
  testTerms();
  testExpressions();
  testCentroids();
  testPairSets();
  testTables();
  testValueEnergies();
  testReach();
  testWithoutEnergy();
  testCalls();
  testNoFarPart();
  ctDestroy(tree);
  printf("%d calls\n", callCount);
  return checkResult();
}
