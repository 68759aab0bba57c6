#include "termset.h"

#include <limits.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "checks.h"

/* ---- Values ---- */

static double evaluateBond(Term* term) {
  const double stretch = measureDistance(term->x[0], term->x[1]) - term->numbers[0];
  return 0.5 * term->numbers[1] * (stretch * stretch);
}

static double evaluateAngle(Term* term) {
  const double bend = measureAngle(term->x[0], term->x[1], term->x[2]) - term->numbers[0];
  return 0.5 * term->numbers[1] * (bend * bend);
}

/* The nth power of cosine + i sine is that of n times the angle. */
static Dihedral multiplyAngle(Dihedral z, int n) {
  Dihedral power = {1, 0};
  for (; n > 0; n /= 2) {
    if (n % 2 == 1) {
      power = (Dihedral){power.cosine * z.cosine - power.sine * z.sine, power.cosine * z.sine + power.sine * z.cosine};
    }
    z = (Dihedral){z.cosine * z.cosine - z.sine * z.sine, 2 * z.cosine * z.sine};
  }
  return power;
}

/* The term's dihedral. */
static Dihedral dihedralOf(Term* term) {
  if (!term->sharesDihedral) {
    term->dihedral = measureDihedral(term->x[0], term->x[1], term->x[2], term->x[3]);
  }
  return term->dihedral;
}

static double evaluatePeriodicTorsion(Term* term) {
  const double* p = term->numbers;
  const Dihedral multiple = multiplyAngle(dihedralOf(term), (int)p[0]);
  return p[1] + (p[2] * multiple.cosine + p[3] * multiple.sine);
}

static double evaluateRyckaertBellemans(Term* term) {
  const double* c = term->numbers;
  const double z = -dihedralOf(term).cosine;
  return c[0] + z * (c[1] + z * (c[2] + z * (c[3] + z * (c[4] + z * c[5]))));
}

static double evaluateException(Term* term) {
  const double* p = term->numbers;
  const double inverse = 1 / measureDistance(term->x[0], term->x[1]);
  const double ratio = p[1] * inverse;
  const double squared = ratio * ratio;
  const double sixth = squared * squared * squared;
  return 4 * p[2] * (sixth - 1) * sixth + CT_COULOMB * p[0] * inverse;
}

static double evaluateMap(Term* term) {
  const double(*x)[3] = term->x;
  return evaluateTorsionMap(&term->set->maps[(int)term->numbers[0]], angleOf(measureDihedral(x[0], x[1], x[2], x[3])),
                            angleOf(measureDihedral(x[4], x[5], x[6], x[7])));
}

static double evaluateExpression(Term* term) {
  const PeriodicBox* box = term->set->isPeriodic ? term->box : NULL;
  return ctExpressionEvaluate(&term->set->expression, term->x, box, term->numbers, term->results, &term->isLong);
}

static double evaluateCentroids(Term* term) {
  const TermSet* set = term->set;
  const int size = set->width / set->groupCount;
  const double* weight = term->numbers + set->stride - set->width;
  const double(*x)[3] = term->x;
  for (int group = 0; group < set->groupCount; group++) {
    double total = 0;
    double sum[3] = {0, 0, 0};
    for (int i = 0; i < size; i++, weight++, x++) {
      total += *weight;
      for (int d = 0; d < 3; d++) {
        sum[d] += *weight * (*x)[d];
      }
    }
    for (int d = 0; d < 3; d++) {
      set->centroids[group][d] = sum[d] / total;
    }
  }
  return ctExpressionEvaluate(&set->expression, (const double(*)[3])set->centroids, set->isPeriodic ? term->box : NULL,
                              term->numbers, term->results, &term->isLong);
}

/* ---- Kinds ---- */

/* What is known of a kind of term. */
typedef struct Kind {
  const char* name;
  int particles;     /* of a term; CT_NULL: any, as for parameters */
  int parameters;    /* of a term */
  int measured;      /* particles of each distance, angle or dihedral; 0: an expression says which */
  bool isOfDihedral; /* which terms of the same particles share */
  double (*evaluate)(Term* term);
} Kind;

static const Kind kinds[] = {
    [ctHarmonicBondTerm] = {"harmonic bonds", 2, 2, 2, false, evaluateBond},
    [ctHarmonicAngleTerm] = {"harmonic angles", 3, 2, 3, false, evaluateAngle},
    [ctPeriodicTorsionTerm] = {"periodic torsions", 4, 3, 4, true, evaluatePeriodicTorsion},
    [ctRyckaertBellemansTerm] = {"Ryckaert-Bellemans", 4, 6, 4, true, evaluateRyckaertBellemans},
    [ctTorsionMapTerm] = {"torsion maps", 8, 1, 4, false, evaluateMap},
    [ctExceptionTerm] = {"exceptions", 2, 3, 2, false, evaluateException},
    [ctExpressionTerm] = {"expressions", CT_NULL, CT_NULL, 0, false, evaluateExpression},
    [ctCentroidTerm] = {"expressions of centroids", CT_NULL, CT_NULL, 0, false, evaluateCentroids},
};

/* ---- Checks ---- */

static bool mapIsValid(const ctTorsionMap* map, int index, int number, char* text, size_t size) {
  const int64_t patches = (int64_t)map->size * map->size;
  if (map->size < 1 || patches > CT_MOST_COUNT / 16) {
    return ctInvalid(text, size, "map %d of term set %d has size %d", index, number, map->size);
  }
  if (map->coefficients == NULL) {
    return ctInvalid(text, size, "the coefficients of map %d of term set %d are NULL", index, number);
  }
  for (int64_t i = 0; i < 16 * patches; i++) {
    if (!isfinite(map->coefficients[i])) {
      return ctInvalid(text, size, "coefficient %d of map %d of term set %d is %g", (int)i, index, number,
                       map->coefficients[i]);
    }
  }
  return true;
}

/* The particles of each point of an expression. */
static int pointSize(const ctTermSet* set) {
  return set->kind == ctCentroidTerm ? set->particlesPerTerm / set->groupsPerTerm : 1;
}

static bool countsAreValid(const ctTermSet* set, int number, char* text, size_t size) {
  if ((int)set->kind < 0 || (size_t)set->kind >= sizeof kinds / sizeof kinds[0]) {
    return ctInvalid(text, size, "term set %d is of the unknown kind %d", number, (int)set->kind);
  }
  const Kind* kind = &kinds[set->kind];
  if (set->count < 0 || set->particlesPerTerm < 0 || set->parametersPerTerm < 0 || set->mapCount < 0) {
    return ctInvalid(text, size,
                     "term set %d has a negative count: %d terms of %d particles and %d parameters, %d maps", number,
                     set->count, set->particlesPerTerm, set->parametersPerTerm, set->mapCount);
  }
  if (set->mapCount > CT_MOST_COUNT || (int64_t)set->count * set->particlesPerTerm > CT_MOST_COUNT ||
      (int64_t)set->count * set->parametersPerTerm > CT_MOST_COUNT || set->particlesPerTerm > CT_MOST_COUNT ||
      set->parametersPerTerm > CT_MOST_COUNT) {
    return ctInvalid(text, size, "term set %d is too large: %d terms of %d particles and %d parameters, %d maps",
                     number, set->count, set->particlesPerTerm, set->parametersPerTerm, set->mapCount);
  }
  if ((set->count > 0 && set->particlesPerTerm > 0 && set->particles == NULL) ||
      (set->count > 0 && set->parametersPerTerm > 0 && set->parameters == NULL) ||
      (set->mapCount > 0 && set->maps == NULL)) {
    return ctInvalid(text, size, "the particles, parameters or maps of term set %d are NULL", number);
  }
  if (kind->particles != CT_NULL && set->particlesPerTerm != kind->particles) {
    return ctInvalid(text, size, "term set %d (%s) has %d particles a term; it needs %d", number, kind->name,
                     set->particlesPerTerm, kind->particles);
  }
  if (kind->parameters != CT_NULL && set->parametersPerTerm != kind->parameters) {
    return ctInvalid(text, size, "term set %d (%s) has %d parameters a term; it needs %d", number, kind->name,
                     set->parametersPerTerm, kind->parameters);
  }
  if (set->kind == ctCentroidTerm &&
      (set->groupsPerTerm < 1 || set->groupsPerTerm > set->particlesPerTerm ||
       set->particlesPerTerm % set->groupsPerTerm != 0 || set->parametersPerTerm < set->particlesPerTerm)) {
    return ctInvalid(text, size, "term set %d has %d groups, %d particles and %d parameters a term", number,
                     set->groupsPerTerm, set->particlesPerTerm, set->parametersPerTerm);
  }
  for (int i = 0; i < set->mapCount; i++) {
    if (!mapIsValid(&set->maps[i], i, number, text, size)) {
      return false;
    }
  }
  if (kind->measured == 0) {
    char name[50];
    if (set->expression == NULL) {
      return ctInvalid(text, size, "term set %d has no expression", number);
    }
    snprintf(name, sizeof name, "the expression of term set %d", number);
    const int points = set->kind == ctCentroidTerm ? set->groupsPerTerm : set->particlesPerTerm;
    return ctExpressionIsValid(set->expression, name, points, set->parametersPerTerm, text, size);
  }
  return true;
}

static bool isWholeBelow(double value, double end) {
  return value >= 0 && value < end && value == floor(value);
}

static bool termIsValid(const ctDefinition* scene, const ctTermSet* set, int number, int term, const int* slotOf,
                        char* text, size_t size) {
  const int* particles = set->particles + (size_t)term * (size_t)set->particlesPerTerm;
  const double* parameters = set->parameters + (size_t)term * (size_t)set->parametersPerTerm;
  for (int i = 0; i < set->particlesPerTerm; i++) {
    if (particles[i] < 0 || particles[i] >= scene->particleCount) {
      return ctInvalid(text, size, "term %d of term set %d names particle %d; there are %d particles", term, number,
                       particles[i], scene->particleCount);
    }
    if (slotOf[particles[i]] == CT_NULL) {
      return ctInvalid(text, size, "term %d of term set %d names particle %d, which is not listed in the scene", term,
                       number, particles[i]);
    }
  }
  if (set->kind == ctPeriodicTorsionTerm && !isWholeBelow(parameters[0], INT_MAX)) {
    return ctInvalid(text, size, "term %d of term set %d has the periodicity %g, which is not a whole number from 0 on",
                     term, number, parameters[0]);
  }
  if (set->kind == ctTorsionMapTerm && !isWholeBelow(parameters[0], set->mapCount)) {
    return ctInvalid(text, size, "term %d of term set %d has map %g; there are %d maps", term, number, parameters[0],
                     set->mapCount);
  }
  for (int i = 0; i < set->parametersPerTerm && kinds[set->kind].measured != 0; i++) {
    if (!isfinite(parameters[i])) {
      return ctInvalid(text, size, "parameter %d of term %d of term set %d is %g", i, term, number, parameters[i]);
    }
  }
  return true;
}

bool ctTermSetIsValid(const ctDefinition* scene, const ctTermSet* set, int number, const int* slotOf, char* text,
                      size_t size) {
  if (!countsAreValid(set, number, text, size)) {
    return false;
  }
  for (int term = 0; term < set->count; term++) {
    if (!termIsValid(scene, set, number, term, slotOf, text, size)) {
      return false;
    }
  }
  return true;
}

bool ctTermSetFitsBox(const ctDefinition* scene, const ctTermSet* set, const int* molecules) {
  if (kinds[set->kind].measured == 0 && ctExpressionHasCoordinate(set->expression)) {
    return false;
  }
  const int together = set->isPeriodic ? pointSize(set) : set->particlesPerTerm; /* these have to be of one molecule */
  for (int i = 0; i < set->count * set->particlesPerTerm; i++) {
    const int first = set->particles[i - i % set->particlesPerTerm % together];
    if (molecules[scene->particleLinks[set->particles[i]]] != molecules[scene->particleLinks[first]]) {
      return false;
    }
  }
  return true;
}

/* ---- Life ---- */

/* Of a periodic torsion: n, k, k cos(phase), k sin(phase). */
static void prepare(const ctTermSet* from, int term, double* numbers) {
  const double* given = from->parameters + (size_t)term * (size_t)from->parametersPerTerm;
  if (from->kind == ctPeriodicTorsionTerm) {
    numbers[0] = given[0];
    numbers[1] = given[2];
    numbers[2] = given[2] * cos(given[1]);
    numbers[3] = given[2] * sin(given[1]);
  } else if (from->parametersPerTerm > 0) {
    memcpy(numbers, given, (size_t)from->parametersPerTerm * sizeof *numbers);
  }
}

static bool copyMaps(const ctTermSet* from, TermSet* set) {
  set->maps = calloc((size_t)from->mapCount + 1, sizeof *set->maps);
  if (set->maps == NULL) {
    return false;
  }
  set->mapCount = from->mapCount;
  for (int i = 0; i < from->mapCount; i++) {
    const size_t size = (size_t)from->maps[i].size;
    double* coefficients = malloc(16 * size * size * sizeof *coefficients);
    if (coefficients == NULL) {
      return false;
    }
    memcpy(coefficients, from->maps[i].coefficients, 16 * size * size * sizeof *coefficients);
    set->maps[i] = (TorsionMap){from->maps[i].size, coefficients};
  }
  return true;
}

bool ctTermSetCreate(const ctTermSet* from, int firstTerm, const int* slotOf, TermSet* set) {
  const size_t count = (size_t)from->count;
  const size_t width = (size_t)from->particlesPerTerm;
  *set = (TermSet){.kind = from->kind,
                   .count = from->count,
                   .firstTerm = firstTerm,
                   .width = from->particlesPerTerm,
                   .isPeriodic = from->isPeriodic,
                   .stride = from->kind == ctPeriodicTorsionTerm ? 4 : from->parametersPerTerm};
  const size_t stride = (size_t)set->stride;
  set->slots = malloc((count * width + 1) * sizeof *set->slots);
  set->numbers = malloc((count * stride + 1) * sizeof *set->numbers);
  if (set->slots == NULL || set->numbers == NULL || !copyMaps(from, set)) {
    return false;
  }
  for (size_t i = 0; i < count * width; i++) {
    set->slots[i] = slotOf[from->particles[i]];
  }
  for (int term = 0; term < from->count; term++) {
    prepare(from, term, set->numbers + (size_t)term * stride);
  }
  if (from->kind == ctCentroidTerm) {
    set->groupCount = from->groupsPerTerm;
    set->centroids = malloc((size_t)set->groupCount * sizeof *set->centroids);
    if (set->centroids == NULL) {
      return false;
    }
  }
  if (kinds[from->kind].measured == 0) {
    set->isAnchored = ctExpressionHasCoordinate(from->expression);
    return ctExpressionCopy(from->expression, &set->expression);
  }
  return true;
}

void ctTermSetFree(TermSet* set) {
  for (int i = 0; i < set->mapCount; i++) {
    free(set->maps[i].coefficients);
  }
  free(set->maps);
  free(set->slots);
  free(set->numbers);
  free(set->centroids);
  ctExpressionFree(&set->expression);
}

/* ---- Terms ---- */

static int particlesOfInput(const ctInput* input, int size, int* particles) {
  const int count = ctMeasureWidth(input->measure) * size;
  for (int i = 0; i < count; i++) {
    particles[i] = input->particles[i / size] * size + i % size;
  }
  return count;
}

int ctMeasuredParticles(const ctTermSet* set, int measure, int* particles) {
  const int width = kinds[set->kind].measured;
  if (width == 0) {
    return measure < set->expression->inputCount
               ? particlesOfInput(&set->expression->inputs[measure], pointSize(set), particles)
               : 0;
  }
  if (measure * width >= set->particlesPerTerm) {
    return 0;
  }
  for (int i = 0; i < width; i++) {
    particles[i] = measure * width + i;
  }
  return width;
}

bool ctMeasuresPlace(const ctTermSet* set, int measure) {
  return kinds[set->kind].measured == 0 && ctMeasureWidth(set->expression->inputs[measure].measure) == 1;
}

/* Evaluates a term of nearest images. */
static double evaluateImages(Term* term) {
  enum { MOST_PARTICLES = 8 };
  const Kind* kind = &kinds[term->set->kind];
  const double(*x)[3] = term->x;
  const double* points[MOST_PARTICLES];
  double chain[MOST_PARTICLES][3];
  for (int begin = 0; begin < kind->particles; begin += kind->measured) {
    for (int i = 0; i < kind->measured; i++) {
      points[i] = x[begin + i];
    }
    term->isLong = !chainOfImages(term->box, kind->measured, points, chain + begin) || term->isLong;
  }
  term->x = (const double(*)[3])chain;
  const double value = kind->evaluate(term);
  term->x = x;
  return value;
}

double ctTermEvaluate(Term* term) {
  const Kind* kind = &kinds[term->set->kind];
  term->isLong = false;
  return term->box != NULL && term->set->isPeriodic && kind->measured > 0 ? evaluateImages(term) : kind->evaluate(term);
}

bool ctTermSetRepeats(const TermSet* set, int term) {
  const int* slots = set->slots + 4 * (size_t)term;
  return kinds[set->kind].isOfDihedral && term > 0 && memcmp(slots, slots - 4, 4 * sizeof *slots) == 0;
}
