#include "nonbonded.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "switching.h"

static void setPotential(Potential* p, const ctNonbonded* d) {
  *p = (Potential){0};
  p->hasCutoff = isfinite(d->cutoff);
  p->hasSwitch = p->hasCutoff && d->switchingDistance < d->cutoff;
  p->exact[0] = p->hasCutoff ? d->cutoff * d->cutoff : INFINITY;
  p->isEwald = d->ewaldAlpha > 0;
  if (p->isEwald) {
    ctEwaldCreate(d->ewaldAlpha, d->cutoff, &p->ewald);
  } else if (p->hasCutoff) {
    const double both = 2 * d->dielectric + 1;
    p->exact[1] = (d->dielectric - 1) / (both * d->cutoff * d->cutoff * d->cutoff);
    p->exact[2] = 3 * d->dielectric / (both * d->cutoff);
  }
  if (p->hasSwitch) {
    p->exact[3] = d->switchingDistance;
    p->exact[4] = 1 / (d->cutoff - d->switchingDistance);
  }
  p->squaredCutoff = squareOfCutoff(d->cutoff);
  p->k = (float)p->exact[1];
  p->c = (float)p->exact[2];
  p->switchingDistance = (float)p->exact[3];
  p->inverseSwitchWidth = (float)p->exact[4];
}

/* Writes what is wrong with a description; false if nothing is. */
static bool isWrong(int particleCount, const ctNonbonded* d, const int* slotOf, char* errorText, size_t errorSize) {
  if (d->exclusionCount < 0 || d->exclusionCount > CT_MOST_COUNT) {
    return snprintf(errorText, errorSize, "there are %d exclusions", d->exclusionCount) > 0;
  }
  if (d->exclusionCount > 0 && d->exclusions == NULL) {
    return snprintf(errorText, errorSize, "the exclusions are NULL") > 0;
  }
  if (particleCount > 0 && (d->charges == NULL || d->sigmas == NULL || d->epsilons == NULL)) {
    return snprintf(errorText, errorSize, "the charges, sigmas or epsilons are NULL") > 0;
  }
  for (int i = 0; i < particleCount; i++) {
    if (slotOf[i] == CT_NULL) {
      return snprintf(errorText, errorSize, "particle %d stands in no leaf", i) > 0;
    }
    if (!isfinite(d->charges[i]) || !isfinite(d->sigmas[i]) || !isfinite(d->epsilons[i]) || d->epsilons[i] < 0) {
      return snprintf(errorText, errorSize,
                      "the charge, sigma or epsilon of particle %d is not finite, or its epsilon is negative", i) > 0;
    }
  }
  for (int i = 0; i < d->exclusionCount; i++) {
    for (int k = 0; k < 2; k++) {
      if (d->exclusions[i][k] < 0 || d->exclusions[i][k] >= particleCount) {
        return snprintf(errorText, errorSize, "exclusion %d names particle %d, but there are %d particles", i,
                        d->exclusions[i][k], particleCount) > 0;
      }
    }
  }
  if (!(d->cutoff > 0)) {
    return snprintf(errorText, errorSize, "the cutoff is %g nm, but has to be above 0", d->cutoff) > 0;
  }
  if (isfinite(d->cutoff) && !(d->switchingDistance >= 0)) {
    return snprintf(errorText, errorSize, "the switching distance is %g nm, but has to be at least 0",
                    d->switchingDistance) > 0;
  }
  if (!(d->ewaldAlpha >= 0 && (d->ewaldAlpha == 0 || d->ewaldAlpha * d->cutoff <= CT_MOST_EWALD))) {
    return snprintf(errorText, errorSize, "alpha is %g / nm, but with a cutoff of %g nm it has to be from 0 to %g / nm",
                    d->ewaldAlpha, d->cutoff, CT_MOST_EWALD / d->cutoff) > 0;
  }
  Potential p;
  setPotential(&p, d);
  if (p.hasCutoff && !(isfinite(p.k) && isfinite(p.c) && isfinite(p.inverseSwitchWidth) && isfinite(p.ewald.scale))) {
    return snprintf(errorText, errorSize,
                    "the potential of a cutoff of %g nm, a dielectric of %g and a switch from %g nm is not finite",
                    d->cutoff, d->dielectric, d->switchingDistance) > 0;
  }
  return false;
}

static void setColumns(Nonbonded* nonbonded, int particleCount, const ctNonbonded* d, const int* slotOf) {
  for (int i = 0; i < particleCount; i++) {
    LeafColumns* columns = &nonbonded->columns[slotOf[i] / CT_LEAF_WIDTH];
    const int k = slotOf[i] % CT_LEAF_WIDTH;
    columns->charge[k] = (float)(sqrt(CT_COULOMB) * d->charges[i]);
    columns->sigma[k] = (float)(d->sigmas[i] / 2);
    columns->epsilon[k] = (float)(2 * sqrt(d->epsilons[i]));
    columns->occupied |= 1u << k;
  }
}

ctStatus ctNonbondedCreate(Nonbonded* nonbonded, const ctChainTree* tree, int particleCount,
                           const ctNonbonded* description, const int* slotOf, char* errorText, size_t errorSize) {
  *nonbonded = (Nonbonded){0};
  if (isWrong(particleCount, description, slotOf, errorText, errorSize)) {
    return ctInvalidArgument;
  }
  const int leafCount = ctGetLeafCount(tree);
  nonbonded->wide = ctFindWide(ctGetInstructionSet(tree));
  nonbonded->columns = calloc((size_t)leafCount + 1, sizeof *nonbonded->columns);
  if (nonbonded->columns == NULL ||
      !ctPairMaskCreate(&nonbonded->mask, leafCount, description->exclusionCount, description->exclusions, slotOf)) {
    ctNonbondedFree(nonbonded);
    snprintf(errorText, errorSize, "out of memory");
    return ctOutOfMemory;
  }
  setPotential(&nonbonded->potential, description);
  setColumns(nonbonded, particleCount, description, slotOf);
  return ctSuccess;
}

void ctNonbondedFree(Nonbonded* nonbonded) {
  free(nonbonded->columns);
  ctPairMaskFree(&nonbonded->mask);
  nonbonded->columns = NULL;
}

/* ---- Energies ---- */

/* The energy of two leaves in double precision, for particles so near that single precision overflows. */
static double exactEnergy(const Nonbonded* nonbonded, const LeafSide* a, const LeafSide* b) {
  const double* exact = nonbonded->potential.exact;
  double sum = 0;
  for (unsigned rows = a->columns->occupied; rows != 0; rows &= rows - 1) {
    const int k = __builtin_ctz(rows);
    unsigned others = b->columns->occupied & ~(a->excluded != NULL ? (unsigned)a->excluded[k] : 0);
    for (; others != 0; others &= others - 1) {
      const int l = __builtin_ctz(others);
      const double x = b->frame->centre[0] - a->frame->centre[0] + (double)b->frame->x[l] - (double)a->frame->x[k];
      const double y = b->frame->centre[1] - a->frame->centre[1] + (double)b->frame->y[l] - (double)a->frame->y[k];
      const double z = b->frame->centre[2] - a->frame->centre[2] + (double)b->frame->z[l] - (double)a->frame->z[k];
      const double squared = x * x + y * y + z * z;
      if (!(squared < exact[0])) {
        continue;
      }
      const double distance = sqrt(squared);
      const double ratio = ((double)a->columns->sigma[k] + (double)b->columns->sigma[l]) / distance;
      const double ratio6 = ratio * ratio * ratio * ratio * ratio * ratio;
      double energy = (double)a->columns->epsilon[k] * (double)b->columns->epsilon[l] * ratio6 * (ratio6 - 1);
      if (nonbonded->potential.hasSwitch && distance > exact[3]) {
        const double t = (distance - exact[3]) * exact[4];
        energy *= switchFactor(t);
      }
      const double others = nonbonded->potential.isEwald ? -ctEwaldSmooth(&nonbonded->potential.ewald, squared)
                                                         : exact[1] * squared - exact[2];
      sum += energy + (double)a->columns->charge[k] * (double)b->columns->charge[l] * (1 / distance + others);
    }
  }
  return sum;
}

static double energyOfPair(const Nonbonded* nonbonded, const FramedPair* pair) {
  const int a = pair->a;
  const int b = pair->b;
  const PairMask* mask = &nonbonded->mask;
  const uint16_t* excluded[2] = {NULL, NULL};
  excluded[0] = pair->isImage ? pairMaskOfImage(mask, a, b) : pairMaskOf(mask, a, b);
  if (excluded[0] != NULL) {
    excluded[1] = pair->isImage ? pairMaskOfImage(mask, b, a) : pairMaskOf(mask, b, a);
  }
  const LeafSide sideA = {pair->frames[0], &nonbonded->columns[a], excluded[0]};
  const LeafSide sideB = {pair->frames[1], &nonbonded->columns[b], excluded[1]};
  const double energy = nonbonded->wide->leafPairEnergy(&nonbonded->potential, &sideA, &sideB);
  return isfinite(energy) ? energy : exactEnergy(nonbonded, &sideA, &sideB);
}

double ctNonbondedEnergy(const Nonbonded* nonbonded, int a, const LeafFrame* frameA, int b, const LeafFrame* frameB) {
  const FramedPair pair = {a, b, false, {frameA, frameB}};
  return energyOfPair(nonbonded, &pair);
}

void ctNonbondedEnergies(const void* model, int count, const FramedPair* pairs, double* energies) {
  for (int i = 0; i < count; i++) {
    energies[i] = energyOfPair(model, &pairs[i]);
  }
}
