// The samples of a cell's leaves: one texel of every square of 1, 2, 4… texels, or of every second square, as on a chessboard.
//
// The choice of texels depends on the surface and the seed, not on the center: all wedges of a point get the same samples, and
// the error of a field varies smoothly.
layout(binding = UNIT_LABELS) uniform isampler2D labels;
layout(binding = UNIT_BOXES) uniform isampler2D boxes;

// Decodes the number of a leaf, 8 bits each.
int of_leaf(int codes, int leaf) { return codes >> 8 * leaf & 255; }

// With more doublings than this, samples belong to the whole cell instead of a leaf.
int most_doublings() { return 2 * findMSB(search.block_size / 2); }

struct Squares {
  ivec2 low, end; // range of square numbers along x and y
  int doublings;
};

// The squares from which the samples of a leaf are taken. Samples of the whole cell are stored as the first leaf's.
Squares squares_of(ivec4 box, int leaf, int doublings) {
  int side = search.block_size / 2, stride = 1 << doublings / 2;
  ivec2 low = box.xy, end = box.xy + box.zw;
  bool joined = doublings > most_doublings();
  if (!joined) {
    ivec2 corner = box.xy / search.block_size * search.block_size + side * ivec2(leaf & 1, leaf >> 1);
    low = max(low, corner);
    end = min(end, corner + side);
  }
  if (any(greaterThanEqual(low, end)) || (joined && leaf > 0)) return Squares(ivec2(0), ivec2(0), doublings);
  return Squares(low / stride, (end - 1) / stride + 1, doublings);
}

// The half that the sample of a square belongs to: a chessboard color or, if only one color has samples, every other column; -1:
// the square has none. The sample alternates among the four texels around the square's middle, so that their mean is the middle:
// nearly even samples measure a disk two to three times as well as jittered ones.
int half_of(int cell, Squares squares, ivec2 square, out ivec2 sample_entry) {
  int stride = 1 << squares.doublings / 2, odd = (square.x ^ square.y) & 1;
  bool one_color = (squares.doublings & 1) != 0;
  ivec2 size = textureSize(labels, 0), texel = square * stride;
  if (stride > 1) texel += stride / 2 - 1 + (ivec2(square.y, square.x) & 1 ^ ivec2(search.seed & 1, search.seed >> 1 & 1));
  if ((one_color && odd != (search.seed >> 2 & 1)) || any(greaterThanEqual(texel, size))) return -1;
  ivec2 label = texelFetch(labels, texel, 0).xy;
  if (label.x != cell || label.y <= 0) return -1;
  float texels = float(1 << squares.doublings) * (float(label.y) / 65536.0);
  sample_entry = ivec2(texel.x | texel.y << 16, floatBitsToInt(texels / (float(size.x) * float(size.y))));
  return one_color ? square.x & 1 : odd;
}
