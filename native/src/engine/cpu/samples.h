// Samples of the surface in blocks of lanes; and which blocks may have samples in a ball.
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "engine/cpu/add_samples.h"
#include "engine/cpu/pieces.h"
#include "support/math.h"

namespace paradesc {

// A list that grows; it is written block by block, each row of a block beside the next.
class Samples {
public:
  // Starts a new list. with_map: samples have the map's rows too.
  void clear(bool with_map);
  // map: gradient and value.
  void add(const Sample &sample, vec4 map);
  // Samples [begin, end) of another list with the same rows.
  void append(const Samples &other, int32_t begin, int32_t end);
  // Fills the last block with samples that have no area.
  void fill_block();
  // Makes room for all of the blocks of other lists, one after the other.
  void resize_blocks(int32_t blocks);
  void copy_blocks(const Samples &other, int32_t block);

  int32_t count() const { return count_; }
  int32_t blocks() const { return (count_ + block_lanes - 1) / block_lanes; }
  // Around the samples of a block, and as far as each reaches.
  vec4 sphere(int32_t block) const;
  const float *data() const { return rows_of_blocks_ ? rows_of_blocks_[0].lane : nullptr; }
  int32_t stride() const { return rows_ * block_lanes; } // floats from block to block

private:
  struct alignas(64) Row {
    float lane[block_lanes];
  };
  Row *rows_of(int32_t block) const { return &rows_of_blocks_[static_cast<size_t>(block) * static_cast<size_t>(rows_)]; }
  void reserve(int32_t count) {
    if (count > room_) grow(count);
  }
  void grow(int32_t count);

  int32_t rows_ = SURFACE_ROWS;
  int32_t count_ = 0, room_ = 0;
  std::unique_ptr<Row[]> rows_of_blocks_; // (blocks, rows)
};

// Blocks of one list that centers near each other look at, in ascending order.
class BlockSet {
public:
  void clear() { count_ = 0; }
  void add(int32_t block, vec4 sphere, float radius);
  bool empty() const { return count_ == 0; }
  int32_t last() const { return block_[static_cast<size_t>(count_) - 1]; }
  SampleBlocks of(const Samples &samples) const;

  // Samples [begin, end) of the list stay when the rest is hidden, as far as their blocks are here.
  void take(int32_t begin, int32_t end);
  void hide_rest();
  void show_all();

private:
  int32_t count_ = 0;
  std::vector<int32_t> block_;
  std::vector<uint16_t> shown_, taken_;  // (count) a bit for each sample
  std::vector<float> middle_[3], limit_; // filled up to block_lanes
};

} // namespace paradesc
