// Options → the device that computes; and where it fails, under AUTO, the next one.
#pragma once

#include <atomic>
#include <list>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <thread>

#include "engine/engines.h"
#include "paradesc/paradesc.h"
#include "support/error.h"
#include "support/workers.h"

namespace paradesc {

struct Context {
  std::atomic<int> backend = PDESC_BACKEND_REFERENCE; // the engine's
  int requested_backend = PDESC_BACKEND_AUTO;
  int device_index = -1;
  int threads = 0;
  int64_t memory_limit = 0;                          // as in pdesc_context_options
  std::shared_ptr<Engine> engine;                    // the one in use
  std::map<int32_t, std::shared_ptr<Engine>> beside; // by backend: for what that one cannot do, opened when first needed
  std::atomic<const char *> device = "";
  std::atomic<const char *> fallback = "";
  bool given_up = false;        // a device that worked at first failed later, as fallback says
  std::list<std::string> texts; // what those two point to, and have pointed to: callers may hold them still
  int smallest_tile = 128;      // centers of the smallest tile, which no result may depend on
  DriverSubstitute substitute;
  Workers workers;                     // of the call
  std::mutex mutex;                    // one call at a time
  std::atomic<std::thread::id> holder; // the thread that has it
};

Resources resources_of(const Context &context);

// substitute: what tests make of the driver.
std::shared_ptr<Context> make_context(const pdesc_context_options &options, DriverSubstitute substitute = {});

// The engine of a backend: the one in use, or one beside it. Throws Error(UNSUPPORTED).
std::shared_ptr<Engine> engine_of(Context &context, int32_t backend);

// Opens a device that was lost once more, where it was asked for by name. Throws Error(DEVICE_LOST).
void reopen_lost_device(Context &context);

// Whether it is the device that failed, not the input or the caller's patience.
bool is_of_device(const Error &error);

// Gives the device up for the next backend, for good; false where the context was made for that device alone.
bool fall_back(Context &context, const Error &error);

} // namespace paradesc
