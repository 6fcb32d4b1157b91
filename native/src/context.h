// Options → the device that computes, and the state that all computations on it share.
#pragma once

#include <atomic>
#include <list>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>

#include "engine/engines.h"
#include "paradesc/paradesc.h"
#include "support/process.h"
#include "support/workers.h"

namespace paradesc {

struct Context {
  int32_t backend = PDESC_BACKEND_CPU; // the engine's
  bool automatic = false;              // options that need texture space go to `software`
  int device_index = -1;
  int threads = 0;
  int64_t memory_limit = 0;         // as in pdesc_context_options
  std::shared_ptr<Engine> engine;   // the one in use; only the thread whose turn it is reads it
  std::shared_ptr<Engine> software; // under AUTO, opened when it is first needed
  std::atomic<const char *> device = "";
  std::list<std::string> devices;     // names that `device` points to, or pointed to: callers may still hold them
  int smallest_tile = 128;            // centers of the smallest tile; no result may depend on it
  std::optional<double> tile_seconds; // as in Resources
  DriverSubstitute substitute;
  Workers workers;                     // help the call
  std::mutex mutex;                    // held by one call at a time
  const long process = this_process(); // the process that made the context
  std::atomic<std::thread::id> holder; // the thread that holds the mutex
};

Resources resources_of(const Context &context);

// substitute: a test's replacement of driver functions.
std::shared_ptr<Context> make_context(const pdesc_context_options &options, DriverSubstitute substitute = {});

// The software device that AUTO uses beside the engine. Throws Error(UNSUPPORTED).
std::shared_ptr<Engine> software_of(Context &context);

// Opens the engine's device again if it was lost. Throws Error(DEVICE_LOST).
void reopen_lost_device(Context &context);

} // namespace paradesc
