#include "energyfile.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

/* A file on its way into an Energy. */
typedef struct Source {
  FILE* file;
  const int* places; /* of each particle of the source in the scene */
  int particleCount;
} Source;

void energyFree(Energy* energy) {
  if (energy == NULL) {
    return;
  }
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
  int* particles = calloc((size_t)set->count + 1, (size_t)set->particlesPerTerm * sizeof(int));
  double* parameters = calloc((size_t)set->count + 1, (size_t)(set->parametersPerTerm + 1) * sizeof(double));
  set->particles = particles;
  set->parameters = parameters;
  bool success = particles != NULL && parameters != NULL;
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
  energy->sets = calloc((size_t)count + 1, sizeof *energy->sets);
  if (energy->sets == NULL) {
    return false;
  }
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
  const size_t count = (size_t)particles;
  nonbonded->charges = energy->charges = calloc(count, sizeof(double));
  nonbonded->sigmas = energy->sigmas = calloc(count, sizeof(double));
  nonbonded->epsilons = energy->epsilons = calloc(count, sizeof(double));
  energy->exclusions = calloc((size_t)nonbonded->exclusionCount + 1, sizeof *energy->exclusions);
  nonbonded->exclusions = (const int(*)[2])energy->exclusions;
  return energy->charges != NULL && energy->sigmas != NULL && energy->epsilons != NULL && energy->exclusions != NULL &&
         readParticles(source, energy) && readExclusions(source, energy) && readSets(source, energy, sets);
}

Energy* energyRead(const char* path, const Scene* scene, char* error, size_t size) {
  int* places = calloc((size_t)scene->particleCount, sizeof(int));
  Energy* energy = calloc(1, sizeof *energy);
  Source source = {.file = fopen(path, "r"), .places = places, .particleCount = scene->particleCount};
  bool success = false;
  if (source.file == NULL) {
    snprintf(error, size, "%s cannot be read", path);
  } else if (places == NULL || energy == NULL) {
    snprintf(error, size, "not enough memory for %s", path);
  } else {
    for (int i = 0; i < scene->particleCount; i++) {
      places[scene->particleNames[i]] = i;
    }
    energy->particleCount = scene->particleCount;
    success = readAll(&source, energy);
    if (!success) {
      snprintf(error, size, "%s is no energy of this scene's %d particles, or ends early", path, scene->particleCount);
    }
  }
  if (source.file != NULL) {
    fclose(source.file);
  }
  free(places);
  if (!success) {
    energyFree(energy);
    return NULL;
  }
  return energy;
}
