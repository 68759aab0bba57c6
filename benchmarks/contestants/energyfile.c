#include "energyfile.h"

#include <math.h>

#include "memory.h"

/* A file on its way into an Energy. */
typedef struct Source {
  FILE* file;
  const int* places; /* of each particle of the source in the scene */
  int particleCount;
} Source;

void energyFree(Energy* energy) {
  for (int s = 0; s < energy->setCount; s++) {
    free((void*)energy->sets[s].particles);
    free((void*)energy->sets[s].parameters);
  }
  free(energy->sets);
  free(energy->charges);
  free(energy->sigmas);
  free(energy->epsilons);
  free(energy->exclusions);
  free(energy);
}

static bool readParticle(const Source* source, int* particle) {
  int number;
  if (fscanf(source->file, "%d", &number) != 1 || number < 0 || number >= source->particleCount) {
    return false;
  }
  *particle = source->places[number];
  return true;
}

static bool readParticles(const Source* source, Energy* energy) {
  for (int i = 0; i < source->particleCount; i++) {
    const int place = source->places[i];
    if (fscanf(source->file, "%lf %lf %lf", &energy->charges[place], &energy->sigmas[place],
               &energy->epsilons[place]) != 3) {
      return false;
    }
  }
  return true;
}

static bool readExclusions(const Source* source, Energy* energy) {
  for (int n = 0; n < energy->nonbonded.exclusionCount; n++) {
    if (!readParticle(source, &energy->exclusions[n][0]) || !readParticle(source, &energy->exclusions[n][1])) {
      return false;
    }
  }
  return true;
}

static bool readSet(const Source* source, ctTermSet* set) {
  int kind;
  if (fscanf(source->file, "%d %d %d %d", &kind, &set->count, &set->particlesPerTerm, &set->parametersPerTerm) != 4 ||
      kind < 0 || kind > (int)ctExceptionTerm || kind == (int)ctTorsionMapTerm || set->count < 0 ||
      set->particlesPerTerm < 1 || set->parametersPerTerm < 0) {
    return false;
  }
  set->kind = (ctTermKind)kind;
  int* particles = allocate(set->count, (size_t)set->particlesPerTerm * sizeof(int));
  double* parameters = allocate(set->count, (size_t)(set->parametersPerTerm + 1) * sizeof(double));
  set->particles = particles;
  set->parameters = parameters;
  bool success = true;
  for (int n = 0; n < set->count && success; n++) {
    for (int k = 0; k < set->particlesPerTerm && success; k++) {
      success = readParticle(source, &particles[n * set->particlesPerTerm + k]);
    }
    for (int k = 0; k < set->parametersPerTerm && success; k++) {
      success = fscanf(source->file, "%lf", &parameters[n * set->parametersPerTerm + k]) == 1;
    }
  }
  return success;
}

static bool readSets(const Source* source, Energy* energy, int count) {
  energy->sets = allocate(count, sizeof *energy->sets);
  for (int s = 0; s < count; s++) {
    energy->setCount = s + 1;
    if (!readSet(source, &energy->sets[s])) {
      return false;
    }
  }
  return true;
}

static bool readAll(Source* source, Energy* energy) {
  ctNonbonded* nonbonded = &energy->nonbonded;
  int version = 0;
  int particles = -1;
  int sets = -1;
  if (fscanf(source->file, "chaintree-energy %d particles %d exclusions %d sets %d %lf %lf %lf", &version, &particles,
             &nonbonded->exclusionCount, &sets, &nonbonded->cutoff, &nonbonded->switchingDistance,
             &nonbonded->dielectric) != 7 ||
      version != 1 || particles != source->particleCount || nonbonded->exclusionCount < 0 || sets < 0) {
    return false;
  }
  nonbonded->cutoff = nonbonded->cutoff > 0 ? nonbonded->cutoff : INFINITY;
  nonbonded->switchingDistance = nonbonded->switchingDistance > 0 ? nonbonded->switchingDistance : INFINITY;
  nonbonded->charges = energy->charges = allocate(particles, sizeof(double));
  nonbonded->sigmas = energy->sigmas = allocate(particles, sizeof(double));
  nonbonded->epsilons = energy->epsilons = allocate(particles, sizeof(double));
  energy->exclusions = allocate(nonbonded->exclusionCount, sizeof *energy->exclusions);
  nonbonded->exclusions = (const int(*)[2])energy->exclusions;
  return readParticles(source, energy) && readExclusions(source, energy) && readSets(source, energy, sets);
}

Energy* energyRead(const char* path, const Scene* scene, char* error, size_t size) {
  FILE* file = fopen(path, "r");
  if (file == NULL) {
    snprintf(error, size, "%s cannot be read", path);
    return NULL;
  }
  int* places = allocate(scene->particleCount, sizeof(int));
  for (int i = 0; i < scene->particleCount; i++) {
    places[scene->particleNames[i]] = i;
  }
  Source source = {.file = file, .places = places, .particleCount = scene->particleCount};
  Energy* energy = allocate(1, sizeof *energy);
  if (!readAll(&source, energy)) {
    snprintf(error, size, "%s is no energy of this scene's %d particles, or ends early", path, scene->particleCount);
    energyFree(energy);
    energy = NULL;
  }
  fclose(file);
  free(places);
  return energy;
}
