#include "pairKinds.h"

#include <math.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

enum { MOST_INTERVALS = 12 };

static const long double screening = 0.7L;

void* allocateZeros(size_t count, size_t size)
{
    void* made = calloc(count + 1, size);
    if (made == NULL)
        abort();
    return made;
}

/* ---- Writing expressions ---- */

static int add(randomPairSet* set, ctOperator kind, int a, int b, int c, double constant)
{
    if (set->operationCount == MOST_PAIR_OPERATIONS)
        abort();
    set->operations[set->operationCount] = (ctOperation){kind, {a, b, c}, constant};
    return set->operationCount++;
}

static int unary(randomPairSet* set, ctOperator kind, int a)
{
    return add(set, kind, a, 12345, -7, 0.5); /* what is not taken may be anything */
}

static int binary(randomPairSet* set, ctOperator kind, int a, int b)
{
    return add(set, kind, a, b, -1, 3);
}

static int withConstant(randomPairSet* set, ctOperator kind, int a, double constant)
{
    return add(set, kind, a, 0, 0, constant);
}

static int distance(randomPairSet* set)
{
    return unary(set, ctInputOperator, 0);
}

static int parameter(randomPairSet* set, int side, int p)
{
    return unary(set, ctParameterOperator, side * PAIR_PARAMETERS + p);
}

static int charges(randomPairSet* set)
{
    return binary(set, ctMultiplyOperator, parameter(set, 0, CHARGE), parameter(set, 1, CHARGE));
}

/* ---- Kinds ---- */

static long double mean(const double* first, const double* second)
{
    return ((long double)first[SIGMA] + second[SIGMA]) / 2;
}

static long double product(const double* first, const double* second)
{
    return (long double)first[CHARGE] * second[CHARGE];
}

static PairValue lennardJones(const randomPairSet* set, long double r, const double* first, const double* second)
{
    (void)set;
    long double epsilon = 4 * sqrtl((long double)first[EPSILON] * second[EPSILON]);
    long double twelfth = epsilon * powl(mean(first, second) / r, 12);
    long double sixth = epsilon * powl(mean(first, second) / r, 6);
    long double coulomb = (long double)CT_COULOMB * product(first, second) / r;
    return (PairValue){twelfth - sixth + coulomb, twelfth + sixth + fabsl(coulomb)};
}

static void writeLennardJones(randomPairSet* set)
{
    int r = distance(set);
    int sum = binary(set, ctAddOperator, parameter(set, 0, SIGMA), parameter(set, 1, SIGMA));
    int ratio = binary(set, ctDivideOperator, withConstant(set, ctMultiplyConstantOperator, sum, 0.5), r);
    int twelfth = withConstant(set, ctPowerConstantOperator, ratio, 12);
    int sixth = withConstant(set, ctPowerConstantOperator, ratio, 6);
    int epsilons = binary(set, ctMultiplyOperator, parameter(set, 0, EPSILON), parameter(set, 1, EPSILON));
    int epsilon = withConstant(set, ctMultiplyConstantOperator, unary(set, ctSqrtOperator, epsilons), 4);
    int dispersion = binary(set, ctMultiplyOperator, epsilon, binary(set, ctSubtractOperator, twelfth, sixth));
    int coulomb = withConstant(set, ctMultiplyConstantOperator, charges(set), CT_COULOMB);
    binary(set, ctAddOperator, dispersion, binary(set, ctDivideOperator, coulomb, r));
}

static PairValue debyeHueckel(const randomPairSet* set, long double r, const double* first, const double* second)
{
    (void)set;
    long double screened = 1.8L * product(first, second) * expl(-r / screening) / r;
    long double wall = powl(mean(first, second), 9) * powl(r, -9);
    long double soft = logl(1 + (long double)first[EPSILON] * second[EPSILON] * r * sqrtl(r));
    return (PairValue){screened + wall - soft, fabsl(screened) + wall + soft + 1};
}

static void writeDebyeHueckel(randomPairSet* set)
{
    int r = distance(set);
    int decay = unary(set, ctExpOperator, withConstant(set, ctMultiplyConstantOperator, r, -1 / (double)screening));
    int scaled = withConstant(set, ctMultiplyConstantOperator, charges(set), 1.8);
    int screened = binary(set, ctDivideOperator, binary(set, ctMultiplyOperator, scaled, decay), r);
    int sum = binary(set, ctAddOperator, parameter(set, 1, SIGMA), parameter(set, 0, SIGMA));
    int half = binary(set, ctDivideOperator, sum, withConstant(set, ctConstantOperator, 0, 2));
    int wall = binary(set, ctDivideOperator, withConstant(set, ctPowerConstantOperator, half, 9),
                      withConstant(set, ctPowerConstantOperator, r, 9));
    int epsilons = binary(set, ctMultiplyOperator, parameter(set, 0, EPSILON), parameter(set, 1, EPSILON));
    int grown = binary(set, ctMultiplyOperator, epsilons, withConstant(set, ctPowerConstantOperator, r, 1.5));
    int soft = unary(set, ctLogOperator, withConstant(set, ctAddConstantOperator, grown, 1));
    binary(set, ctSubtractOperator, binary(set, ctAddOperator, screened, wall), soft);
}

/* Of pairs of types. */
static long double tableOfTypes(const randomPairSet* set, int table, const double* first, const double* second)
{
    return set->values[table][(int)first[TYPE] + PAIR_TYPES * (int)second[TYPE]];
}

static PairValue typed(const randomPairSet* set, long double r, const double* first, const double* second)
{
    long double repulsion = tableOfTypes(set, 0, first, second) / powl(r, 12);
    long double attraction = tableOfTypes(set, 1, first, second) / powl(r, 6);
    return (PairValue){repulsion - attraction, repulsion + attraction};
}

static void writeTyped(randomPairSet* set)
{
    int r = distance(set);
    int types[2] = {parameter(set, 0, TYPE), parameter(set, 1, TYPE)};
    int parts[2];
    for (int table = 0; table < 2; table++) {
        int value = add(set, ctTableOperator, types[0], types[1], 0, table);
        parts[table] =
            binary(set, ctDivideOperator, value, withConstant(set, ctPowerConstantOperator, r, table == 0 ? 12 : 6));
    }
    binary(set, ctSubtractOperator, parts[0], parts[1]);
}

static void makeTypedTables(randomPairSet* set, randomSource* random)
{
    for (int table = 0; table < 2; table++) {
        set->values[table] = allocateZeros(PAIR_TYPES * PAIR_TYPES, sizeof(double));
        for (int i = 0; i < PAIR_TYPES; i++)
            for (int j = 0; j <= i; j++)
                set->values[table][i + PAIR_TYPES * j] = set->values[table][j + PAIR_TYPES * i] =
                    table == 0 ? randomReal(random, 0, 1e-6) : randomReal(random, 0, 1e-3);
        set->tables[table] = (ctTable){
            .isDiscrete = true, .dimensions = 2, .sizes = {PAIR_TYPES, PAIR_TYPES}, .values = set->values[table]};
    }
    set->set.tableCount = 2;
}

/* A cubic in the interval of a number; false if there is none. */
static bool placeIn(const ctTable* table, int d, long double x, int* interval, long double* u)
{
    long double width = (long double)table->maxima[d] - table->minima[d];
    long double part = (x - table->minima[d]) / width;
    if (table->isPeriodic)
        part -= floorl(part);
    *interval = (int)floorl(part * table->sizes[d]);
    *u = part * table->sizes[d] - *interval;
    return part >= 0 && part < 1;
}

static PairValue spline(const randomPairSet* set, long double r, const double* first, const double* second)
{
    const ctTable* table = &set->tables[0];
    int interval;
    long double u;
    if (!placeIn(table, 0, r, &interval, &u))
        return (PairValue){0, 0};
    PairValue sum = {0, 0};
    for (int i = 0; i < 4; i++) {
        long double part = product(first, second) * table->values[4 * interval + i] * powl(u, i);
        sum.energy += part;
        sum.size += fabsl(part);
    }
    return sum;
}

static void writeSpline(randomPairSet* set)
{
    int value = add(set, ctTableOperator, distance(set), 0, 0, 0);
    binary(set, ctMultiplyOperator, charges(set), value);
}

static PairValue surface(const randomPairSet* set, long double r, const double* first, const double* second)
{
    const ctTable* table = &set->tables[0];
    int s, t;
    long double u, v;
    if (!placeIn(table, 0, r, &s, &u) || !placeIn(table, 1, (long double)first[SIGMA] + second[SIGMA], &t, &v))
        return (PairValue){0, 0};
    PairValue sum = {0, 0};
    for (int i = 0; i < 4; i++)
        for (int j = 0; j < 4; j++) {
            long double part = table->values[16 * (s + table->sizes[0] * t) + 4 * i + j] * powl(u, i) * powl(v, j);
            sum.energy += part;
            sum.size += fabsl(part);
        }
    return sum;
}

static void writeSurface(randomPairSet* set)
{
    int sum = binary(set, ctAddOperator, parameter(set, 0, SIGMA), parameter(set, 1, SIGMA));
    add(set, ctTableOperator, distance(set), sum, 0, 0);
}

static void makePieces(randomPairSet* set, randomSource* random, int dimensions)
{
    ctTable* table = &set->tables[0];
    *table = (ctTable){.isPeriodic = randomChance(random, 0.5), .dimensions = dimensions};
    size_t length = dimensions == 1 ? 4 : 16;
    for (int d = 0; d < dimensions; d++) {
        table->sizes[d] = 1 + randomInt(random, MOST_INTERVALS);
        table->minima[d] = randomReal(random, -0.1, 0.2);
        table->maxima[d] = table->minima[d] + randomReal(random, 0.1, 1);
        length *= (size_t)table->sizes[d];
    }
    set->values[0] = allocateZeros(length, sizeof(double));
    for (size_t i = 0; i < length; i++)
        set->values[0][i] = randomReal(random, -3, 3);
    table->values = set->values[0];
    set->set.tableCount = 1;
}

static void makeLinePieces(randomPairSet* set, randomSource* random)
{
    makePieces(set, random, 1);
}

static void makeSurfacePieces(randomPairSet* set, randomSource* random)
{
    makePieces(set, random, 2);
}

/* Of Ashbaugh and Hatch: Lennard-Jones of hydropathies; sigmas and charges stand for these. */
static PairValue ashbaughHatch(const randomPairSet* set, long double r, const double* first, const double* second)
{
    PairValue value = lennardJones(set, r, first, second);
    value.energy -= (long double)CT_COULOMB * product(first, second) / r;
    long double epsilon = sqrtl((long double)first[EPSILON] * second[EPSILON]);
    long double lambda = ((long double)first[CHARGE] + second[CHARGE]) / 2;
    bool isInner = r <= powl(2, 1 / 6.0L) * mean(first, second);
    return (PairValue){isInner ? value.energy + epsilon * (1 - lambda) : lambda * value.energy, value.size + epsilon};
}

static void writeAshbaughHatch(randomPairSet* set)
{
    int r = distance(set);
    int sum = binary(set, ctAddOperator, parameter(set, 0, SIGMA), parameter(set, 1, SIGMA));
    int sigma = withConstant(set, ctMultiplyConstantOperator, sum, 0.5);
    int ratio = binary(set, ctDivideOperator, sigma, r);
    int sixth = unary(set, ctSquareOperator, unary(set, ctCubeOperator, ratio));
    int twelfth = unary(set, ctSquareOperator, sixth);
    int roots = binary(set, ctMultiplyOperator, unary(set, ctSqrtOperator, parameter(set, 0, EPSILON)),
                       unary(set, ctSqrtOperator, parameter(set, 1, EPSILON)));
    int depth = withConstant(set, ctMultiplyConstantOperator, roots, 4);
    int dispersion = binary(set, ctMultiplyOperator, depth, binary(set, ctSubtractOperator, twelfth, sixth));
    int hydropathies = binary(set, ctAddOperator, parameter(set, 0, CHARGE), parameter(set, 1, CHARGE));
    int lambda = withConstant(set, ctMultiplyConstantOperator, hydropathies, 0.5);
    int rest = withConstant(set, ctAddConstantOperator, unary(set, ctNegateOperator, lambda), 1);
    int inner = binary(set, ctAddOperator, dispersion, binary(set, ctMultiplyOperator, roots, rest));
    int edge = withConstant(set, ctMultiplyConstantOperator, sigma, pow(2, 1 / 6.0));
    int isInner = unary(set, ctStepOperator, binary(set, ctSubtractOperator, edge, r));
    add(set, ctSelectOperator, isInner, inner, binary(set, ctMultiplyOperator, lambda, dispersion), 0);
}

/* Functions that nothing else asks for. */
static PairValue mixture(const randomPairSet* set, long double r, const double* first, const double* second)
{
    (void)set;
    long double charge = product(first, second);
    long double near = charge * erfcl(r / screening) / r;
    long double wave = fmaxl(fabsl(charge), cosl(5 * r)) + tanhl(r) * sinl(3 * r);
    long double rounded = fminl(charge, atanl(r) - floorl(2 * charge));
    long double power = powl(r + 0.2L, 1 + (long double)first[EPSILON] * second[EPSILON]);
    return (PairValue){near + wave + rounded + power, fabsl(near) + fabsl(charge) + 5 + fabsl(power)};
}

static void writeMixture(randomPairSet* set)
{
    int r = distance(set);
    int charge = charges(set);
    int error = unary(set, ctErfcOperator, withConstant(set, ctMultiplyConstantOperator, r, 1 / (double)screening));
    int near = binary(set, ctMultiplyOperator, charge, binary(set, ctDivideOperator, error, r));
    int cosine = unary(set, ctCosOperator, withConstant(set, ctMultiplyConstantOperator, r, 5));
    int sine = unary(set, ctSinOperator, withConstant(set, ctMultiplyConstantOperator, r, 3));
    int most = binary(set, ctMaxOperator, unary(set, ctAbsOperator, charge), cosine);
    int wave = binary(set, ctAddOperator, most, binary(set, ctMultiplyOperator, unary(set, ctTanhOperator, r), sine));
    int whole = unary(set, ctFloorOperator, withConstant(set, ctMultiplyConstantOperator, charge, 2));
    int turned = binary(set, ctSubtractOperator, unary(set, ctAtanOperator, r), whole);
    int rounded = binary(set, ctMinOperator, charge, turned);
    int epsilons = binary(set, ctMultiplyOperator, parameter(set, 0, EPSILON), parameter(set, 1, EPSILON));
    int power = binary(set, ctPowerOperator, withConstant(set, ctAddConstantOperator, r, 0.2),
                       withConstant(set, ctAddConstantOperator, epsilons, 1));
    binary(set, ctAddOperator, binary(set, ctAddOperator, near, wave), binary(set, ctAddOperator, rounded, power));
}

/* What knows of no distance: pairs within the cutoff are counted. */
static PairValue counted(const randomPairSet* set, long double r, const double* first, const double* second)
{
    (void)set;
    (void)r;
    long double value = 2.5L + (long double)first[CHARGE] * second[CHARGE];
    return (PairValue){value, fabsl(value) + 2.5L};
}

static void writeCounted(randomPairSet* set)
{
    withConstant(set, ctAddConstantOperator, charges(set), 2.5);
}

/* On a way that no float goes. */
static PairValue beyondFloats(const randomPairSet* set, long double r, const double* first, const double* second)
{
    (void)set;
    long double value = product(first, second) + r;
    return (PairValue){value, fabsl(value) + 1};
}

static void writeBeyondFloats(randomPairSet* set)
{
    int sum = binary(set, ctAddOperator, charges(set), distance(set));
    withConstant(set, ctMultiplyConstantOperator, withConstant(set, ctMultiplyConstantOperator, sum, 1e200), 1e-200);
}

const PairKind pairKinds[PAIR_KINDS] = {
    {lennardJones, writeLennardJones, NULL},
    {debyeHueckel, writeDebyeHueckel, NULL},
    {typed, writeTyped, makeTypedTables},
    {spline, writeSpline, makeLinePieces},
    {surface, writeSurface, makeSurfacePieces},
    {ashbaughHatch, writeAshbaughHatch, NULL},
    {mixture, writeMixture, NULL},
    {counted, writeCounted, NULL},
    {beyondFloats, writeBeyondFloats, NULL},
};
