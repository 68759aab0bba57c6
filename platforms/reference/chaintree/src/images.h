/* Periodic images. In a periodic scene every pair counts in all images: particle A, shifted by any sum of box vectors,
 * against particle B. A search first looks at the scene as it is, without shift. Then it looks for pairs of the scene
 * with its images. It descends into nodes that may meet in any image with a shift, all images at a time. Particles are
 * compared in the nearest image of the pair: no other is within half of the box's width, which no reach exceeds. */
#ifndef CT_IMAGES_H_
#define CT_IMAGES_H_

#include <stdbool.h>

/* How many of each box vector, and their sum in nm. */
typedef struct Image {
  int n[3];
  double shift[3];
} Image;

/* So that numbers of vectors, and differences of these, are an int. */
#define MOST_VECTORS 0x1p29

/* The box. Its vectors are the rows; as in OpenMM, the first is along x, and the second has no z. */
typedef struct PeriodicBox {
  bool isPeriodic;
  double vectors[3][3];
  double inverse[3][3]; /* rows: how many of each vector a position is */
  double across[3];     /* how many of each vector a nm is, along the normal of the other two */
} PeriodicBox;

/* The images of box A, along the world's axes, that are within reach of box B; begins before the first. */
typedef struct ImageRange {
  const PeriodicBox* box;
  double low[3]; /* no shift is lower, or higher */
  double high[3];
  int end[3]; /* one past the last of each vector, given the later ones */
  Image image;
} ImageRange;

/* The shift of an image from how many of each vector. Opposite images have opposite shifts, bit by bit. */
Image ctImageOf(const PeriodicBox* box, const int n[3]);
void ctImageShift(const PeriodicBox* box, const int n[3], double shift[3]);

/* False for the scene itself, without shift. */
static inline bool isImage(const Image* image) {
  return image->n[0] != 0 || image->n[1] != 0 || image->n[2] != 0;
}

/* True for one of two opposite images, and not for the scene itself. */
static inline bool isFirstOfOpposite(const int n[3]) {
  return n[2] != 0 ? n[2] > 0 : n[1] != 0 ? n[1] > 0 : n[0] > 0;
}

/* The squared distance of two points, the first shifted. The same bits if points and shift are exchanged. */
static inline double squaredImageDistance(const double a[3], const double b[3], const Image* image) {
  double squared = 0;
  for (int d = 0; d < 3; d++) {
    const double apart = a[d] - b[d] + image->shift[d];
    squared += apart * apart;
  }
  return squared;
}

/* Begins with all images but the scene itself. */
ImageRange ctImageRange(const PeriodicBox* box, const double lowA[3], const double highA[3], const double lowB[3],
                        const double highB[3], double reach);

/* Takes the next image; false if there is none. */
bool ctNextImage(ImageRange* range);

/* The image of a point that is nearest to another, `apart` being the first less the second: exact where they are less
 * than half the box's width from each other. */
Image ctNearestImage(const PeriodicBox* box, const double apart[3]);

/* The box of these vectors. */
PeriodicBox ctPeriodicBox(const double (*vectors)[3]);

/* The least distance between opposite faces. A particle meets at most one image of another within half of that. */
double ctBoxWidth(const PeriodicBox* box);

/* Checks box vectors. Returns what is wrong, or NULL. */
const char* ctFindBoxFault(const double (*vectors)[3]);

#endif /* CT_IMAGES_H_ */
