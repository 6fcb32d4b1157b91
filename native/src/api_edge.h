// The shared parts of the C edge: exceptions become codes and sentences, structs of older and newer callers are read and written,
// arguments are checked.
#pragma once

#include <algorithm>
#include <array>
#include <cstring>
#include <initializer_list>
#include <new>
#include <string>
#include <string_view>

#include "support/error.h"

namespace paradesc::edge {

// The sentence of this thread's last failure, in memory of fixed size, so that it can be set when no other memory is left.
class LastError {
public:
  const char *text() const { return text_.data(); }
  // Concatenates the parts as far as there is room, cutting between characters of UTF-8.
  void set(std::initializer_list<std::string_view> parts) noexcept {
    size_t length = 0;
    for (const std::string_view part : parts) {
      size_t fits = std::min(part.size(), text_.size() - 1 - length);
      while (fits > 0 && fits < part.size() && (part[fits] & 0xC0) == 0x80) --fits;
      length += part.copy(text_.data() + length, fits);
      if (fits < part.size()) break;
    }
    text_[length] = 0;
  }

private:
  std::array<char, 4096> text_{};
};
LastError &last_error();

// Runs a call's body and turns any exception into a code and a sentence.
template <class Body> int32_t guarded(const Body &body) noexcept {
  LastError &sentence = last_error();
  try {
    sentence.set({});
    body();
    sentence.set({}); // left by calls from the progress callback
    return PDESC_OK;
  } catch (const Error &error) {
    sentence.set({error.what()});
    return error.status();
  } catch (const std::bad_alloc &) {
    sentence.set({"Out of memory; use a smaller mesh or smaller buffers."});
    return PDESC_ERROR_OUT_OF_MEMORY;
  } catch (const std::exception &error) {
    sentence.set({"Internal error: ", error.what(), "; please report it."});
    return PDESC_ERROR_UNKNOWN;
  } catch (...) {
    sentence.set({"Internal error of unknown kind; please report it."});
    return PDESC_ERROR_UNKNOWN;
  }
}

[[noreturn]] inline void refuse(const std::string &sentence) { throw Error(PDESC_ERROR_INVALID_ARGUMENT, sentence); }

inline void need(const void *pointer, const char *name) {
  if (!pointer) refuse(std::string("The argument '") + name + "' is NULL; pass a valid pointer.");
}

// A caller may be older or newer than the library: members that it did not pass keep their defaults, unknown ones are ignored.
template <class Struct> Struct read_struct(const Struct *input, void (*init)(Struct *), const char *name) {
  Struct ours;
  init(&ours);
  if (!input) return ours;
  if (input->struct_size < 2 * sizeof(uint32_t) || input->struct_size > 4096 || input->struct_size % alignof(Struct) != 0)
    refuse(std::string(name) + ".struct_size is " + std::to_string(input->struct_size) + "; call " + name +
           "_init before filling it.");
  std::memcpy(static_cast<void *>(&ours), input, std::min<size_t>(input->struct_size, sizeof(Struct)));
  return ours;
}

template <class Struct> void write_struct(Struct ours, Struct *out, const char *name) {
  need(out, name);
  const uint32_t size = out->struct_size;
  if (size < sizeof(uint32_t) || size > 4096 || size % alignof(Struct) != 0) // a size that ends within a member
    refuse(std::string(name) + ".struct_size is " + std::to_string(size) + "; call " + name + "_init first.");
  ours.struct_size = size;
  std::memcpy(static_cast<void *>(out), &ours, std::min<size_t>(size, sizeof(Struct)));
}

template <class Struct> void zero_init(Struct *value) {
  if (!value) return;
  std::memset(static_cast<void *>(value), 0, sizeof *value);
  value->struct_size = sizeof *value;
}

inline void check_range(const char *name, long long value, long long low, long long high) {
  if (value < low || value > high)
    refuse(std::string("The option ") + name + " is " + std::to_string(value) + "; choose from " + std::to_string(low) + " to " +
           std::to_string(high) + ".");
}

} // namespace paradesc::edge
