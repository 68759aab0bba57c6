/* A set of terms of one kind, as trials need it. */
#ifndef CT_TERMSET_H_
#define CT_TERMSET_H_

#include "expression.h"
#include "torsionmap.h"

typedef struct TermSet {
  ctTermKind kind;
  int count;
  int firstTerm; /* its number among all terms */
  int width;     /* particles a term */
  int* slots;    /* width a term */
  int stride;    /* numbers a term */
  double* numbers;
  int mapCount;
  TorsionMap* maps;
  Expression expression;
  bool isAnchored;        /* moves of a whole term change it */
  int groupCount;         /* of a term of centroids, as the next */
  double (*centroids)[3]; /* scratch: of each group */
  int changeableCount;    /* terms that some trial can change */
  bool isPeriodic;        /* see ctTermSet */
  bool isUnshifted;       /* in a periodic box it is of positions without the shifts of molecules */
} TermSet;

/* True if a set is right for a scene; else text, of `size` bytes, says in a sentence which term of set number `number`
 * is wrong, and why. slotOf[particle] is its slot, or CT_NULL. */
bool ctTermSetIsValid(const ctDefinition* scene, const ctTermSet* set, int number, const int* slotOf, char* text,
                      size_t size);

/* True if molecules of a periodic box, see ctFindMolecules, may be shifted without a change of the value. */
bool ctTermSetFitsBox(const ctDefinition* scene, const ctTermSet* set, const int* molecules);

/* Makes a set from a valid description. False if there is no memory; it has to be freed all the same. */
bool ctTermSetCreate(const ctTermSet* from, int firstTerm, const int* slotOf, TermSet* set);

void ctTermSetFree(TermSet* set);

/* A measure is of four points at most. */
enum { MOST_POINTS = 4 };

/* The particles of each term that measure number `measure` is of, as their numbers in the term. Returns how many, up to
 * MOST_POINTS times all particles of the term; 0: there is no such measure. */
int ctMeasuredParticles(const ctTermSet* set, int measure, int* particles);

/* True if the measure is of a place in the world. */
bool ctMeasuresPlace(const ctTermSet* set, int measure);

/* A term that is evaluated. */
typedef struct Term {
  const TermSet* set;
  const double* numbers;
  const double (*x)[3];   /* positions of its particles */
  const PeriodicBox* box; /* NULL: none */
  bool isLong;            /* out: some difference of positions is not shorter than half the box's width */
  bool sharesDihedral;    /* with the term that was evaluated before */
  Dihedral dihedral;      /* of the last torsion */
  double* results;        /* scratch for the operations of an expression */
} Term;

double ctTermEvaluate(Term* term);

/* True if a term has the dihedral of the term before, and shares it. */
bool ctTermSetRepeats(const TermSet* set, int term);

#endif /* CT_TERMSET_H_ */
