/* Closures of windows in backbones of proteins: the solver against brute force, and how long it takes.
 *
 *     chaintree_closures WINDOWS STEPS SEED < backbones
 *
 * The input has a line for each residue: nine coordinates in nm, of N, CA and C, and whether phi and psi are free; an
 * empty line ends a chain. A window is eight or nine free torsions in a row, with three residues as pivots of which
 * both are free. In every other window drivers turn by up to 16 degrees, as they do on the way there; in the others
 * they do not, and one closure is known, as on the way back. Brute force begins with STEPS turns of the first pivot; 0
 * leaves it out. The program prints a line of JSON, and returns 1 if the solver has missed or invented a closure.
 */
#define _POSIX_C_SOURCE 199309L
#include <time.h>

#include "comparison.h"

#define LARGEST_TURN (16 * PI / 180)

/* All windows are solved this number of times, one after the other, so that the processor cannot learn a single window.
 * The shortest time of each counts: longer ones include other work of the machine. */
#define RUNS 7

typedef struct Problem {
  ctWindow window;
  double drivers[CT_WINDOW_MOST];
  double all; /* us */
  double near;
} Problem;

typedef struct FreeTorsion {
  int chain;
  int from; /* the atom at which its axis begins */
} FreeTorsion;

typedef struct Backbones {
  double (*atoms)[3];
  FreeTorsion* torsions;
  int atomCount;
  int torsionCount;
} Backbones;

static void* grown(void* memory, size_t count, size_t size) {
  void* more = realloc(memory, count * size);
  if (more == NULL) {
    printf("out of memory\n");
    exit(1);
  }
  return more;
}

static void readBackbones(Backbones* b) {
  char line[1024];
  int chain = 0;
  while (fgets(line, sizeof line, stdin) != NULL) {
    double x[9];
    int isFree[2];
    if (sscanf(line, "%lf %lf %lf %lf %lf %lf %lf %lf %lf %d %d", &x[0], &x[1], &x[2], &x[3], &x[4], &x[5], &x[6],
               &x[7], &x[8], &isFree[0], &isFree[1]) != 11) {
      chain++;
      continue;
    }
    b->atoms = grown(b->atoms, (size_t)b->atomCount + 3, sizeof *b->atoms);
    b->torsions = grown(b->torsions, (size_t)b->torsionCount + 2, sizeof *b->torsions);
    memcpy(b->atoms + b->atomCount, x, sizeof x);
    for (int k = 0; k < 2; k++) {
      if (isFree[k]) {
        b->torsions[b->torsionCount++] = (FreeTorsion){chain, b->atomCount + k};
      }
    }
    b->atomCount += 3;
  }
}

static void drawWindow(const Backbones* b, ctWindow* window) {
  for (;;) {
    const int count = uniform(0, 1) < 0.5 ? 8 : 9;
    const int first = (int)uniform(0, b->torsionCount - count + 1);
    const FreeTorsion* torsions = b->torsions + first;
    if (torsions[0].chain != torsions[count - 1].chain) {
      continue;
    }
    int pairs[CT_WINDOW_MOST];
    int pairCount = 0;
    window->count = 0;
    for (int i = 0; i < count; i++) {
      addTorsion(window, b->atoms, torsions[i].from, torsions[i].from + 1);
      if (i > 0 && torsions[i].from % 3 == 1 && torsions[i - 1].from == torsions[i].from - 1) {
        pairs[pairCount++] = i - 1;
      }
    }
    if (pairCount < 3) {
      continue;
    }
    int left = 3;
    for (int i = 0; left > 0; i++) {
      if (uniform(0, pairCount - i) < left) {
        window->pivots[2 * (3 - left)] = pairs[i];
        window->pivots[2 * (3 - left) + 1] = pairs[i] + 1;
        left--;
      }
    }
    return;
  }
}

static double microseconds(const struct timespec* start) {
  struct timespec end;
  clock_gettime(CLOCK_MONOTONIC, &end);
  return 1e6 * (double)(end.tv_sec - start->tv_sec) + 1e-3 * (double)(end.tv_nsec - start->tv_nsec);
}

static void timeProblems(Problem* problems, int count) {
  for (int i = 0; i < count * RUNS; i++) {
    Problem* p = &problems[i % count];
    double solutions[CT_CLOSURES_MOST][CT_PIVOTS];
    struct timespec start;
    clock_gettime(CLOCK_MONOTONIC, &start);
    ctFindClosures(&p->window, p->drivers, solutions);
    p->all = fmin(p->all, microseconds(&start));
  }
  /* Where no driver turns, the near closure is at hand: of no interest. */
  for (int i = 0; i < count * RUNS; i += 2) {
    Problem* p = &problems[i % count];
    double angles[CT_WINDOW_MOST];
    memcpy(angles, p->drivers, sizeof angles);
    struct timespec start;
    clock_gettime(CLOCK_MONOTONIC, &start);
    ctCloseNear(&p->window, angles);
    p->near = fmin(p->near, microseconds(&start));
  }
}

static int byValue(const void* a, const void* b) {
  const double x = *(const double*)a, y = *(const double*)b;
  return (x > y) - (x < y);
}

static void printTimes(const char* name, double* times, int count) {
  qsort(times, (size_t)count, sizeof *times, byValue);
  printf(", \"%s\": {\"microseconds\": %.3f, \"percentile99\": %.3f, \"worst\": %.3f}", name, times[count / 2],
         times[(long long)count * 99 / 100], times[count - 1]);
}

int main(int argc, char** argv) {
  const int count = argc > 1 ? atoi(argv[1]) / 2 * 2 : 1000;
  const int steps = argc > 2 ? atoi(argv[2]) : 0;
  chance += argc > 3 ? (uint64_t)atoll(argv[3]) : 0;
  for (int i = 0; i < 100; i++) {
    uniform(0, 1); /* so that seeds which are near each other part */
  }
  Backbones backbones = {0};
  readBackbones(&backbones);
  if (count < 1 || count > 1000000 || steps < 0 || backbones.torsionCount < 9) {
    printf("usage: %s WINDOWS STEPS SEED < backbones\n", argv[0]);
    return 2;
  }
  Problem* problems = grown(NULL, (size_t)count, sizeof *problems);
  for (int n = 0; n < count; n++) {
    Problem* p = &problems[n];
    drawWindow(&backbones, &p->window);
    drawDrivers(&p->window, n % 2 ? 0 : LARGEST_TURN, p->drivers);
    p->all = INFINITY;
    p->near = INFINITY;
  }
  timeProblems(problems, count);
  Comparison sum = {0};
  int closable = 0; /* windows whose drivers have turned */
  int closed = 0;
  int histogram[CT_CLOSURES_MOST + 1] = {0};
  for (int n = 0; n < count; n++) {
    const Problem* p = &problems[n];
    double angles[CT_WINDOW_MOST], solutions[CT_CLOSURES_MOST][CT_PIVOTS];
    const int solutionCount = ctFindClosures(&p->window, p->drivers, solutions);
    histogram[solutionCount]++;
    memcpy(angles, p->drivers, sizeof angles);
    if (n % 2 == 0) {
      closable += solutionCount > 0 ? 1 : 0;
      closed += ctCloseNear(&p->window, angles) ? 1 : 0;
    }
    if (steps > 0) {
      compareClosures(&p->window, p->drivers, steps, &sum);
    }
  }
  printf("{\"windows\": %d, \"closable\": %d, \"closed\": %d, \"counts\": [", count, closable, closed);
  for (int i = 0; i <= CT_CLOSURES_MOST; i++) {
    printf("%s%d", i > 0 ? ", " : "", histogram[i]);
  }
  printf("]");
  if (steps > 0) {
    printf(", \"solutions\": %d, \"known\": %d, \"missed\": %d, \"invented\": %d, \"unknown\": %d, \"gap\": %.2g",
           sum.solutions, sum.known, sum.missed, sum.invented, sum.doubtful, sum.worstGap);
  }
  double* times = grown(NULL, (size_t)count, sizeof *times);
  for (int n = 0; n < count; n++) {
    times[n] = problems[n].all;
  }
  printTimes("all", times, count);
  int turned = 0;
  for (int n = 0; n < count; n += 2) {
    times[turned++] = problems[n].near;
  }
  printTimes("near", times, turned);
  printf("}\n");
  free(times);
  free(problems);
  free(backbones.atoms);
  free(backbones.torsions);
  return sum.missed > 0 || sum.invented > 0 || sum.doubtful > 0;
}
