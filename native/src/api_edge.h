// What the calls of the C edge share: exceptions become codes and sentences, structs of callers of another age are read and
// written, arguments are checked.
#pragma once

#include <algorithm>
#include <cstring>
#include <new>
#include <string>

#include "support/error.h"

namespace paradesc::edge {

std::string &last_error(); // sentence of this thread's last failure

// Runs a call's body; whatever it throws becomes a code and a sentence.
template <class Body> int32_t guarded(const Body &body) noexcept {
  try {
    last_error().clear();
    body();
    last_error().clear(); // of calls from the progress callback
    return PDESC_OK;
  } catch (const Error &error) {
    last_error() = error.what();
    return error.status();
  } catch (const std::bad_alloc &) {
    last_error() = "Out of memory; use a smaller mesh or smaller buffers.";
    return PDESC_ERROR_OUT_OF_MEMORY;
  } catch (const std::exception &error) {
    last_error() = std::string("Internal error: ") + error.what() + "; please report it.";
    return PDESC_ERROR_UNKNOWN;
  } catch (...) {
    last_error() = "Internal error of unknown kind; please report it.";
    return PDESC_ERROR_UNKNOWN;
  }
}

[[noreturn]] inline void refuse(const std::string &sentence) { throw Error(PDESC_ERROR_INVALID_ARGUMENT, sentence); }

inline void need(const void *pointer, const char *name) {
  if (!pointer) refuse(std::string("The argument '") + name + "' is NULL; pass a valid pointer.");
}

// A caller may be older or newer than the library: what it did not pass keeps its default, what we do not know is left alone.
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
  if (size < sizeof(uint32_t) || size > 4096 || size % alignof(Struct) != 0) // half a member
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
