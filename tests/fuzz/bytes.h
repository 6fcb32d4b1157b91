// A fuzzer's bytes → numbers, biased to those that programs trip over. Past the end all bytes are 0.
#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>
#include <limits>

namespace paradesc::fuzz {

class Bytes {
public:
  Bytes(const uint8_t *data, size_t size) : data_(data), size_(size) {}

  bool empty() const { return at_ >= size_; }
  uint8_t byte() { return empty() ? uint8_t{0} : data_[at_++]; }
  int below(int count) { return byte() % count; }              // count up to 256
  bool one_in(int count) { return below(count) == count - 1; } // false past the end

  uint32_t word() {
    uint32_t value = 0;
    for (int i = 0; i < 4; ++i) value = value << 8 | byte();
    return value;
  }

  // Whole numbers that overflow, wrap or fall off an end; else small ones around 0.
  int32_t whole() {
    constexpr int32_t edges[] = {std::numeric_limits<int32_t>::min(),
                                 std::numeric_limits<int32_t>::max(),
                                 -1,
                                 0,
                                 1,
                                 63,
                                 64,
                                 65,
                                 1 << 16,
                                 1 << 30,
                                 std::numeric_limits<int32_t>::max() / 3,
                                 std::numeric_limits<int32_t>::max() / 3 + 1};
    const uint8_t choice = byte();
    if (choice < 12) return edges[choice];
    if (choice < 16) return std::bit_cast<int32_t>(word());
    return choice - 128;
  }

  // One in four is a number with a name in IEEE 754, a threshold of the library or any bits at all; the others lie on a grid, so
  // that positions coincide.
  float number() {
    using limits = std::numeric_limits<float>;
    constexpr float edges[] = {limits::quiet_NaN(),
                               limits::infinity(),
                               -limits::infinity(),
                               limits::max(),
                               -limits::max(),
                               limits::min(),
                               limits::denorm_min(),
                               -limits::denorm_min(),
                               -0.0f,
                               1e18f,
                               -1e18f,
                               1.0000001e18f,
                               1e-18f,
                               1e-30f,
                               1e30f,
                               limits::epsilon(),
                               1.0f + limits::epsilon(),
                               0.999999f,
                               1e-7f,
                               1e9f,
                               16777217.0f,
                               2147483648.0f,
                               -2147483648.0f,
                               1e-20f,
                               1e10f,
                               0.25f};
    const uint8_t choice = byte();
    if (choice < 26) return edges[choice];
    if (choice < 40) return std::bit_cast<float>(word());
    if (choice < 64) return static_cast<float>(static_cast<int16_t>(word())) / 1024.0f;
    return static_cast<float>(choice - 64) / 16.0f - 4.0f;
  }

  // A number that is meant to work, three times in four.
  double share() { return one_in(4) ? static_cast<double>(number()) : (byte() + 1) / 256.0; }

private:
  const uint8_t *data_;
  size_t size_, at_ = 0;
};

} // namespace paradesc::fuzz
