// A struct of the interface → the bytes that a caller of another age would pass.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <memory>

#include "bytes.h"

namespace paradesc::fuzz {

// A copy of exactly as many bytes as its struct_size says, which may be any number.
template <class Struct> class Passed {
public:
  Passed(Bytes &bytes, const Struct &value) : size_(sizeof(Struct)) {
    if (bytes.one_in(16)) size_ = static_cast<uint32_t>(bytes.one_in(2) ? bytes.whole() : bytes.byte());
    const size_t room = size_ > 4096 ? sizeof(Struct) : std::max<size_t>(size_, sizeof size_);
    bytes_ = std::make_unique<std::byte[]>(room);
    std::memset(bytes_.get(), 0x5A, room);
    std::memcpy(bytes_.get(), &value, std::min(room, sizeof(Struct)));
    std::memcpy(bytes_.get(), &size_, sizeof size_);
  }
  Struct *get() { return reinterpret_cast<Struct *>(bytes_.get()); }
  Struct read() const { // what was not passed is 0
    Struct value{};
    std::memcpy(static_cast<void *>(&value), bytes_.get(),
                std::min<size_t>(size_ > 4096 ? sizeof(Struct) : size_, sizeof(Struct)));
    return value;
  }

private:
  uint32_t size_;
  std::unique_ptr<std::byte[]> bytes_;
};

} // namespace paradesc::fuzz
