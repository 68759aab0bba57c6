#include "born.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

/* ---- Checks ---- */

static bool isFinitePositive(double x) {
  return isfinite(x) && x > 0;
}

/* The name of an array that is read and is not there; NULL if there is none. */
static const char* findMissing(int particleCount, const ctBorn* d) {
  const struct {
    const char* name;
    const void* array;
    bool isRead;
  } arrays[] = {{"charges", d->charges, true},
                {"radii", d->radii, true},
                {"offsetRadii", d->offsetRadii, true},
                {"scaledRadii", d->scaledRadii, true},
                {"alphas", d->alphas, d->isRescaled},
                {"betas", d->betas, d->isRescaled},
                {"gammas", d->gammas, d->isRescaled},
                {"neckTypes", d->neckTypes, d->neckTypeCount > 0},
                {"neckHeights", d->neckHeights, d->neckTypeCount > 0},
                {"neckDistances", d->neckDistances, d->neckTypeCount > 0}};
  for (size_t i = 0; i < sizeof arrays / sizeof arrays[0]; i++) {
    if (particleCount > 0 && arrays[i].isRead && arrays[i].array == NULL) {
      return arrays[i].name;
    }
  }
  return NULL;
}

/* Writes what is wrong with a particle; false if nothing is. */
static bool isParticleWrong(int i, const ctBorn* d, const int* slotOf, char* errorText, size_t errorSize) {
  if (slotOf[i] == CT_NULL) {
    return snprintf(errorText, errorSize, "particle %d stands in no leaf", i) > 0;
  }
  if (!isfinite(d->charges[i]) || !isfinite(d->scaledRadii[i])) {
    return snprintf(errorText, errorSize, "the charge or the scaled radius of particle %d is not finite", i) > 0;
  }
  if (!isFinitePositive(d->radii[i]) || !isFinitePositive(d->offsetRadii[i])) {
    return snprintf(errorText, errorSize,
                    "the radius of particle %d is %g nm and its offset radius %g nm, but both have to be above 0", i,
                    d->radii[i], d->offsetRadii[i]) > 0;
  }
  if (d->isRescaled && (!isfinite(d->alphas[i]) || !isfinite(d->betas[i]) || !isfinite(d->gammas[i]))) {
    return snprintf(errorText, errorSize, "alpha, beta or gamma of particle %d is not finite", i) > 0;
  }
  if (d->neckTypeCount > 0 && (d->neckTypes[i] < 0 || d->neckTypes[i] >= d->neckTypeCount)) {
    return snprintf(errorText, errorSize, "particle %d has neck type %d, but there are %d types", i, d->neckTypes[i],
                    d->neckTypeCount) > 0;
  }
  return false;
}

/* The same of the whole description. */
static bool isWrong(int particleCount, const ctBorn* d, const int* slotOf, char* errorText, size_t errorSize) {
  if (d->neckTypeCount < 0 || (int64_t)d->neckTypeCount * d->neckTypeCount > CT_MOST_COUNT) {
    return snprintf(errorText, errorSize, "the number of neck types is %d", d->neckTypeCount) > 0;
  }
  const char* missing = findMissing(particleCount, d);
  if (missing != NULL) {
    return snprintf(errorText, errorSize, "%s of Born is NULL", missing) > 0;
  }
  for (int i = 0; i < particleCount; i++) {
    if (isParticleWrong(i, d, slotOf, errorText, errorSize)) {
      return true;
    }
  }
  for (int i = 0; i < d->neckTypeCount * d->neckTypeCount; i++) {
    if (!isfinite(d->neckHeights[i]) || !isfinite(d->neckDistances[i])) {
      return snprintf(errorText, errorSize, "the height or distance of the neck of types %d and %d is not finite",
                      i % d->neckTypeCount, i / d->neckTypeCount) > 0;
    }
  }
  if (d->neckTypeCount > 0 && (!isfinite(d->neckScale) || !isfinite(d->neckCut))) {
    return snprintf(errorText, errorSize, "the scale or the cut of necks is not finite") > 0;
  }
  if (!isFinitePositive(d->soluteDielectric) || !isFinitePositive(d->solventDielectric)) {
    return snprintf(errorText, errorSize, "the dielectrics are %g and %g, but both have to be above 0",
                    d->soluteDielectric, d->solventDielectric) > 0;
  }
  if (!isfinite(d->kappa) || d->kappa < 0) {
    return snprintf(errorText, errorSize, "kappa is %g nm^-1, but has to be finite and at least 0", d->kappa) > 0;
  }
  if (!isfinite(d->coulomb) || d->coulomb < 0) {
    return snprintf(errorText, errorSize, "the Coulomb constant of Born is %g, but has to be finite and at least 0",
                    d->coulomb) > 0;
  }
  if (!isfinite(d->surfaceEnergy) || !isfinite(d->probeRadius) || !isfinite(d->shift)) {
    return snprintf(errorText, errorSize, "the surface energy, the probe radius or the shift of Born is not finite") >
           0;
  }
  if (!(d->cutoff > 0)) {
    return snprintf(errorText, errorSize, "the cutoff of Born is %g nm, but has to be above 0", d->cutoff) > 0;
  }
  return false;
}

/* ---- Making ---- */

static double greater(double a, double b) {
  return a > b ? a : b;
}

/* A little more, so that rounding loses no particle. */
static float squaredReach(double reach) {
  return (float)(1.0001 * reach * reach);
}

static void setModel(BornModel* model, int particleCount, const ctBorn* d, const BornNecks* necks) {
  double radius = 0; /* the largest of each */
  double leastRadius = INFINITY;
  double offset = 0;
  double scaled = 0;
  for (int i = 0; i < particleCount; i++) {
    radius = greater(radius, d->radii[i]);
    leastRadius = fmin(leastRadius, d->radii[i]);
    offset = greater(offset, d->offsetRadii[i]);
    scaled = greater(scaled, fabs(d->scaledRadii[i]));
  }
  const double near = greater(scaled + offset, scaled / BORN_FAR_RATIO);
  const double far = scaled / BORN_REMOTE_RATIO;
  const double neckReach = d->neckTypeCount > 0 ? greater(2 * radius + d->neckCut, 0) : 0;
  *model = (BornModel){
      .neckTypeCount = d->neckTypeCount,
      .hasCutoff = isfinite(d->cutoff),
      .isRescaled = d->isRescaled,
      .isFilled = d->isFilled,
      .necks = necks,
      .neckCut = (float)d->neckCut,
      .squaredNear = squaredReach(near),
      .squaredFar = squaredReach(far),
      .squaredNeckReach = squaredReach(neckReach),
      .squaredLeastNeckReach = (float)(0.9999 * pow(greater(2 * leastRadius + d->neckCut, 0), 2)),
      .squaredReach = squaredReach(greater(greater(near, far), neckReach)),
      .perDielectrics = {(float)(1 / d->soluteDielectric), (float)(1 / d->solventDielectric)},
      .kappa = (float)d->kappa,
      .shift = (float)d->shift,
      .coulomb = d->coulomb,
      .dielectrics = {d->soluteDielectric, d->solventDielectric},
      .exactKappa = d->kappa,
      .exactShift = d->shift,
      .exactCutoff = d->cutoff * d->cutoff,
      .surfaceEnergy = d->surfaceEnergy,
      .probeRadius = d->probeRadius,
  };
  model->squaredCutoff = squareOfCutoff(d->cutoff);
}

static void setParticles(Born* born, int particleCount, const ctBorn* d, const int* slotOf) {
  for (int leaf = 0; leaf < born->leafCount; leaf++) {
    for (int k = 0; k < CT_LEAF_WIDTH; k++) {
      born->columns[leaf].radius[k] = 1;
      born->columns[leaf].offsetRadius[k] = 1;
    }
  }
  for (int i = 0; i < particleCount; i++) {
    BornColumns* columns = &born->columns[slotOf[i] / CT_LEAF_WIDTH];
    const int k = slotOf[i] % CT_LEAF_WIDTH;
    const double scaled = d->scaledRadii[i];
    columns->charge[k] = (float)(sqrt(d->coulomb) * d->charges[i]);
    columns->radius[k] = (float)d->radii[i];
    columns->offsetRadius[k] = (float)d->offsetRadii[i];
    columns->scaledRadius[k] = (float)scaled;
    columns->squaredScaled[k] = (float)(scaled * scaled);
    columns->cubedScaled[k] = (float)(scaled * scaled * scaled);
    const float remote[] = BORN_REMOTE_SERIES;
    const float far[] = BORN_FAR_SERIES;
    for (int n = 0; n < 5; n++) {
      const double power = pow(scaled, 3 + 2 * n);
      if (n < 3) {
        columns->remote[n][k] = (float)((double)remote[n] * power);
      }
      columns->far[n][k] = (float)((double)far[n] * power);
    }
    columns->neckReach[k] = (float)(d->radii[i] + d->neckCut);
    columns->neckType[k] = d->neckTypeCount > 0 ? d->neckTypes[i] : 0;
    columns->occupied |= 1u << k;
    born->particles[slotOf[i]] = (BornParticle){
        .charge = d->charges[i],
        .radius = d->radii[i],
        .offsetRadius = d->offsetRadii[i],
        .alpha = d->isRescaled ? d->alphas[i] : 0,
        .beta = d->isRescaled ? d->betas[i] : 0,
        .gamma = d->isRescaled ? d->gammas[i] : 0,
    };
  }
}

static void setNecks(Born* born, const ctBorn* d) {
  const int types = d->neckTypeCount;
  for (int leaf = 0; leaf < born->leafCount; leaf++) {
    const BornColumns* columns = &born->columns[leaf];
    for (int type = 0; type < types; type++) {
      BornNecks* necks = &born->necks[(size_t)leaf * (size_t)types + (size_t)type];
      for (unsigned slots = columns->occupied; slots != 0; slots &= slots - 1) {
        const int k = __builtin_ctz(slots);
        const int forOne = type + types * columns->neckType[k];
        const int forLeaf = columns->neckType[k] + types * type;
        necks->heightForOne[k] = (float)(d->neckScale * d->neckHeights[forOne]);
        necks->distanceForOne[k] = (float)d->neckDistances[forOne];
        necks->heightForLeaf[k] = (float)(d->neckScale * d->neckHeights[forLeaf]);
        necks->distanceForLeaf[k] = (float)d->neckDistances[forLeaf];
      }
    }
  }
}

ctStatus ctBornCreate(Born* born, int leafCount, int particleCount, const ctBorn* d, const int* slotOf, char* errorText,
                      size_t errorSize) {
  *born = (Born){0};
  if (isWrong(particleCount, d, slotOf, errorText, errorSize)) {
    return ctInvalidArgument;
  }
  const size_t leaves = (size_t)leafCount + 1;
  Born made = {
      .leafCount = leafCount,
      .columns = calloc(leaves, sizeof *made.columns),
      .particles = calloc(leaves * CT_LEAF_WIDTH, sizeof *made.particles),
      .necks = calloc(leaves * (size_t)d->neckTypeCount + 1, sizeof *made.necks),
  };
  if (made.columns == NULL || made.particles == NULL || made.necks == NULL) {
    ctBornFree(&made);
    snprintf(errorText, errorSize, "out of memory");
    return ctOutOfMemory;
  }
  setModel(&made.model, particleCount, d, made.necks);
  setParticles(&made, particleCount, d, slotOf);
  setNecks(&made, d);
  *born = made;
  return ctSuccess;
}

void ctBornFree(Born* born) {
  free(born->columns);
  free(born->particles);
  free(born->necks);
  *born = (Born){0};
}

/* ---- Single particles ---- */

double ctBornRadius(const BornModel* model, const BornParticle* particle, double sum) {
  if (!model->isRescaled) {
    return 1 / (1 / particle->offsetRadius - sum);
  }
  const double p = sum * particle->offsetRadius;
  const double scaled = p * (particle->alpha + p * (particle->gamma * p - particle->beta));
  return 1 / (1 / particle->offsetRadius - tanh(scaled) / particle->radius);
}

double ctBornSelfEnergy(const BornModel* model, const BornParticle* particle, double bornRadius) {
  const double screening = exp(-model->exactKappa * bornRadius);
  const double contrast = 1 / model->dielectrics[0] - screening / model->dielectrics[1];
  const double ratio = particle->radius / bornRadius;
  const double around = particle->radius + model->probeRadius;
  return -0.5 * model->coulomb * contrast * particle->charge * particle->charge / bornRadius +
         model->surfaceEnergy * around * around * (ratio * ratio * ratio) * (ratio * ratio * ratio);
}
