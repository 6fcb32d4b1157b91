// Options → the device that computes, with what computations on it share.
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
  bool automatic = false;              // what takes texture space goes to `software`
  Abilities abilities;                 // the engine's
  int device_index = -1;
  int threads = 0;
  int64_t memory_limit = 0;         // as in pdesc_context_options
  std::shared_ptr<Engine> engine;   // the one in use; only the thread whose turn it is reads it
  std::shared_ptr<Engine> software; // under AUTO, opened when it is first needed
  std::atomic<const char *> device = "";
  std::list<std::string> devices;     // the names that `device` points to, and has pointed to: callers may hold them still
  int smallest_tile = 128;            // centers of the smallest tile, which no result may depend on
  std::optional<double> tile_seconds; // as in Resources
  DriverSubstitute substitute;
  Workers workers;                     // of the call
  std::mutex mutex;                    // one call at a time
  const long process = this_process(); // that made it
  std::atomic<std::thread::id> holder; // the thread that has it
};

Resources resources_of(const Context &context);

// substitute: what tests make of the driver.
std::shared_ptr<Context> make_context(const pdesc_context_options &options, DriverSubstitute substitute = {});

// The software device that computes beside the engine under AUTO. Throws Error(UNSUPPORTED).
std::shared_ptr<Engine> software_of(Context &context);

// Opens the engine's device once more if it was lost. Throws Error(DEVICE_LOST).
void reopen_lost_device(Context &context);

} // namespace paradesc
