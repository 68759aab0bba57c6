#include "view.h"

Block* CT_WIDE(moveNode)(Traversal* t, int node) {
  const int entry = t->nextMoved;
  t->nextMoved = entry + 1 < t->movedCapacity ? entry + 1 : 0;
  Block* moved = &t->moved[entry];
  const int other = t->movedNode[entry];
  if (t->inView[other] == moved) {
    t->inView[other] = NULL;
  }
  t->movedNode[entry] = node;
  Block* world = worldOf(t->world, node);
  moveAll(world, world->r, t->motions[t->body[node]], moved);
  return moved;
}

/* A sphere around a mixed node's members in the view. */
static Sphere boundOfMixedNode(const Traversal* t, const MixedNode* s) {
  Sphere bound = middleOfBlock(&s->block);
  /* The members may be mixed nodes: each level adds its own rounding, see FLOAT_MARGIN. */
  bound.r += radiusAbout(bound, &s->block, s->block.r) + (float)floatMargin(t->coordinateBound);
  return bound;
}

void CT_WIDE(placeMixedNode)(Traversal* t, int level, int node, int piece) {
  const View* view = t->view;
  const Tree* tree = t->tree;
  t->placedIn[node] = t->descent;
  t->body[node] = mixedNodeCode(t->mixedNodeCount);
  MixedNode* s = &t->mixedNodes[t->mixedNodeCount++];
  s->node = node;
  s->isBoxed = false;
  t->inView[node] = &s->block;
  updateWorld(t->world, level, node);
  const Block* world = worldOf(t->world, node);
  Float16 x = load16(world->x);
  Float16 y = load16(world->y);
  Float16 z = load16(world->z);
  Float16 r = load16(world->r);
  Float16 bodies = allInts16(0);
  int end;
  const int begin = treeSlots(tree, level, node, &end);
  const int bits = TREE_WIDTH_BITS * level; /* of the width of a member */
  const int first = level == 0 ? 0 : tree->levelBegin[level - 1] + (begin >> bits);
  const int count = (end - begin + (1 << bits) - 1) >> bits;
  int k = 0;
  while (k < count) {
    const int from = begin + (k << bits);
    while (piece + 1 < view->pieceCount && view->pieces[piece + 1].slotBegin <= from) {
      piece++;
    }
    const int next = piece + 1 < view->pieceCount ? view->pieces[piece + 1].slotBegin : end;
    const int wholes = next < end ? (next - begin) >> bits : count;
    if (wholes > k) {
      const int body = view->pieces[piece].body;
      const unsigned mask = (1u << wholes) - (1u << k);
      if (moves(view, body)) {
        x = blend16(mask, x, moved16(world, t->motions[body]));
        y = blend16(mask, y, moved16(world, t->motions[body] + 4));
        z = blend16(mask, z, moved16(world, t->motions[body] + 8));
      }
      bodies = blend16(mask, bodies, allInts16(body));
      k = wholes;
    } else if (level > 0) { /* a slot has one body */
      const int code = t->body[first + k];
      const Sphere bound = boundOfMixedNode(t, mixedNodeOf(t, code));
      x = blend16(1u << k, x, all16(bound.x));
      y = blend16(1u << k, y, all16(bound.y));
      z = blend16(1u << k, z, all16(bound.z));
      r = blend16(1u << k, r, all16(bound.r));
      bodies = blend16(1u << k, bodies, allInts16(code));
      k++;
    }
  }
  store16(s->block.x, x);
  store16(s->block.y, y);
  store16(s->block.z, z);
  store16(s->block.r, r);
  storeInts16(s->body, bodies);
}

void CT_WIDE(startView)(Traversal* t, const View* view) {
  const Tree* tree = t->tree;
  t->view = view;
  const double size = sizeOfState(tree);
  double shift = 0;
  if (view->motions != NULL) {
    for (int i = 1; i < view->motionCount; i++) {
      double translation[3];
      translationOf(&view->motions[i], translation);
      shift = larger(shift, sqrt(dot(translation, translation)));
      floatMotion(&view->motions[i], t->motions[i]);
    }
  }
  t->coordinateBound = size + shift;
  t->tieBand = DOUBLE_MARGIN * t->coordinateBound;
  if (++t->descent == 0) {
    memset(t->placedIn, 0, (size_t)tree->nodeCount * sizeof(uint32_t));
    for (int i = 0; i < t->movedBoxesCapacity; i++) {
      t->movedBoxes[i].descent = 0;
    }
    t->descent = 1;
  }
  t->mixedNodeCount = 0;
  t->nextMoved = 0;
  t->movedBoxesCount = 0;
}

Block* CT_WIDE(viewAgain)(Traversal* t, int node) {
  const int code = t->body[node];
  Block* world = worldOf(t->world, node);
  return code < 0 ? &mixedNodeOf(t, code)->block : moves(t->view, code) ? CT_WIDE(moveNode)(t, node) : world;
}

Visit CT_WIDE(startVisit)(Traversal* t, const View* view, CandidateFunction* function, void* context) {
  CT_WIDE(startView)(t, view);
  const double margin = floatMargin(t->coordinateBound + fabs(view->reach));
  return (Visit){.function = function, .context = context, .reach = (float)(view->reach + margin), .margin = margin};
}
