/* Side branches; paths; and the products of a path's local frames that its return frame inverts. */
#include "order.h"
#include "sequence.h"

/* Links of a block, whose product is multiplied link by link: fewer products are kept. */
enum { PATH_BLOCK = 8 };

static int blockCount(const Sequence* s, int path) {
  return (s->pathBegin[path + 1] - s->pathBegin[path] + PATH_BLOCK - 1) / PATH_BLOCK;
}

/* The number of products over `blocks` blocks: the blocks, pairs of these, and so on down to one. */
static int productCount(int blocks) {
  int count = blocks;
  for (int n = blocks; n > 1; n = (n + 1) / 2) {
    count += (n + 1) / 2;
  }
  return count;
}

/* True if a link is not the last child of its parent: then it begins a path. */
static bool headsPath(const Sequence* s, const int* end, int link) {
  return end[link] != end[s->parent[link]];
}

static SideBranchPart findPart(const Sequence* s, const int* end, int link) {
  const bool heads = headsPath(s, end, link);
  if (s->sideBranchPart[s->parent[link]] != notInSideBranch) {
    return heads ? beginsInnerBranch : continuesSideBranch;
  }
  return heads && s->slotBegin[end[link]] - s->slotBegin[link] <= SIDE_BRANCH_SLOTS ? beginsSideBranch
                                                                                    : notInSideBranch;
}

static void findSideBranches(Sequence* s, const int* end) {
  for (int link = 1; link < s->linkCount; link++) {
    s->sideBranchPart[link] = (uint8_t)findPart(s, end, link);
  }
}

static bool numberPaths(Sequence* s, Arena* arena, const int* end) {
  int pathCount = 1;
  for (int link = 1; link < s->linkCount; link++) {
    const bool heads = headsPath(s, end, link);
    pathCount += heads;
    s->returnFrameCount += heads && s->sideBranchPart[link] == notInSideBranch;
  }
  s->openPathCount = pathCount - s->returnFrameCount;
  s->pathEnd = ctArenaAllocate(arena, (size_t)pathCount, sizeof(int));
  if (arena->failed) {
    return false;
  }
  int closing = 0;
  int other = s->returnFrameCount;
  for (int link = 0; link < s->linkCount; link++) {
    if (link > 0 && !headsPath(s, end, link)) {
      s->pathOf[link] = s->pathOf[s->parent[link]];
    } else {
      s->pathOf[link] = link > 0 && s->sideBranchPart[link] == notInSideBranch ? closing++ : other++;
      s->pathEnd[s->pathOf[link]] = end[link];
    }
  }
  return true;
}

static bool closes(const Sequence* s, int link) {
  return s->pathOf[link] < s->returnFrameCount;
}

bool ctPathsBuild(Sequence* s, Arena* arena, const int* end) {
  findSideBranches(s, end);
  if (!numberPaths(s, arena, end)) {
    return false;
  }
  s->pathBegin = ctArenaAllocate(arena, (size_t)s->returnFrameCount + 2, sizeof(int));
  s->productBegin = ctArenaAllocate(arena, (size_t)s->returnFrameCount + 1, sizeof(int));
  s->returnFrame = ctArenaAllocate(arena, (size_t)s->returnFrameCount, sizeof(Frame));
  if (arena->failed) {
    return false;
  }
  /* Counts are kept two entries on, so that filling the list turns them into its begins. */
  int* next = s->pathBegin + 1;
  for (int link = 1; link < s->linkCount; link++) {
    if (closes(s, link)) {
      next[s->pathOf[link] + 1]++;
    }
  }
  ctAccumulate(next, s->returnFrameCount);
  s->pathLink = ctArenaAllocate(arena, (size_t)next[s->returnFrameCount], sizeof(int));
  if (arena->failed) {
    return false;
  }
  for (int link = 1; link < s->linkCount; link++) {
    if (closes(s, link)) {
      s->pathLink[next[s->pathOf[link]]++] = link;
    }
  }
  for (int path = 0; path < s->returnFrameCount; path++) {
    s->productBegin[path + 1] = s->productBegin[path] + productCount(blockCount(s, path));
  }
  s->product = ctArenaAllocate(arena, (size_t)s->productBegin[s->returnFrameCount], sizeof(Frame));
  return !arena->failed;
}

static void multiplyBlock(Sequence* s, int path, int block) {
  const int begin = s->pathBegin[path] + block * PATH_BLOCK;
  const int end = begin + PATH_BLOCK < s->pathBegin[path + 1] ? begin + PATH_BLOCK : s->pathBegin[path + 1];
  Frame product = sequenceLocalFrame(s, s->pathLink[begin]);
  for (int i = begin + 1; i < end; i++) {
    const Frame localFrame = sequenceLocalFrame(s, s->pathLink[i]);
    product = transformCompose(&product, &localFrame);
  }
  s->product[s->productBegin[path] + block] = product;
}

/* Recomputes these blocks (ascending) of a path and all products over them, each once; returns how many. */
static int multiplyPath(Sequence* s, int path, int* blocks, int count) {
  for (int i = 0; i < count; i++) {
    multiplyBlock(s, path, blocks[i]);
  }
  int multiplied = count;
  Frame* below = s->product + s->productBegin[path];
  for (int n = blockCount(s, path); n > 1; n = (n + 1) / 2) {
    Frame* above = below + n;
    int kept = 0;
    for (int i = 0; i < count; i++) {
      const int pair = blocks[i] / 2;
      if (kept == 0 || blocks[kept - 1] != pair) {
        blocks[kept++] = pair;
        above[pair] = 2 * pair + 1 < n ? transformCompose(&below[2 * pair], &below[2 * pair + 1]) : below[2 * pair];
      }
    }
    count = kept;
    multiplied += kept;
    below = above;
  }
  s->returnFrame[path] = transformInverse(below);
  return multiplied;
}

void ctPathsMultiply(Sequence* s) {
  for (int path = 0; path < s->returnFrameCount; path++) {
    for (int block = 0; block < blockCount(s, path); block++) {
      multiplyPath(s, path, &(int){block}, 1);
    }
  }
}

int ctSequenceUpdate(Sequence* s, const int* links, int count, int* scratch) {
  /* Sorting indices into pathLink sorts by path, and in a path by link. */
  int touched = 0;
  for (int i = 0; i < count; i++) {
    if (closes(s, links[i])) {
      const int* bounds = s->pathBegin + s->pathOf[links[i]];
      scratch[touched++] = ascendingFrom(s->pathLink, bounds[0], bounds[1], links[i]);
    }
  }
  ctSortInts(scratch, touched);
  int multiplied = 0;
  int begin = 0;
  while (begin < touched) {
    const int path = s->pathOf[s->pathLink[scratch[begin]]];
    int blocks = 0;
    int i = begin;
    for (; i < touched && scratch[i] < s->pathBegin[path + 1]; i++) {
      const int block = (scratch[i] - s->pathBegin[path]) / PATH_BLOCK;
      if (blocks == 0 || scratch[begin + blocks - 1] != block) {
        scratch[begin + blocks++] = block;
      }
    }
    multiplied += multiplyPath(s, path, scratch + begin, blocks);
    begin = i;
  }
  return multiplied;
}
