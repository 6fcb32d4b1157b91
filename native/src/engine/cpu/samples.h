// Samples of the surface in blocks of lanes; and which blocks may have samples in a ball.
#pragma once

#include <cstdint>
#include <vector>

#include "engine/cpu/add_samples.h"
#include "support/math.h"

namespace paradesc {

struct Sample {
  vec3 position;
  vec3 normal;
  vec3 face; // of the triangles' planes
  float area;
  vec4 map; // gradient and value
};

// A list that grows; it is written block by block, each row of a block beside the next.
class Samples {
public:
  // Starts a new list. with_map: samples have the map's rows too.
  void clear(bool with_map);
  void add(const Sample &sample);
  // Samples [begin, end) of another list with the same rows.
  void append(const Samples &other, int32_t begin, int32_t end);
  // Fills the last block with samples that have no area.
  void fill_block();

  int32_t count() const { return count_; }
  int32_t blocks() const { return (count_ + block_lanes - 1) / block_lanes; }
  // Around the samples of a block, and as far as each reaches.
  vec4 sphere(int32_t block) const;
  const float *data() const { return blocks_.empty() ? nullptr : blocks_[0].lane; }
  int32_t stride() const { return rows_ * block_lanes; } // floats from block to block

private:
  struct alignas(64) Row {
    float lane[block_lanes];
  };
  Row &row(int32_t block, int row) {
    return blocks_[static_cast<size_t>(block) * static_cast<size_t>(rows_) + static_cast<size_t>(row)];
  }
  const Row &row(int32_t block, int row) const { return const_cast<Samples *>(this)->row(block, row); }
  void reserve(int32_t count);

  int32_t rows_ = SURFACE_ROWS;
  int32_t count_ = 0;
  std::vector<Row> blocks_; // (blocks, rows)
};

// Blocks of one list that centers near each other look at.
class BlockSet {
public:
  void clear() { count_ = 0; }
  void add(int32_t block, vec4 sphere, float radius);
  bool empty() const { return count_ == 0; }
  int32_t last() const { return block_[static_cast<size_t>(count_) - 1]; }
  SampleBlocks of(const Samples &samples) const;

private:
  int32_t count_ = 0;
  std::vector<int32_t> block_;
  std::vector<float> middle_[3], limit_; // filled up to block_lanes
};

} // namespace paradesc
