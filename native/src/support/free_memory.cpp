// Reads /proc/meminfo and the memory limits of control groups, of versions 1 and 2, up to the topmost group.
#include "support/free_memory.h"

#include <algorithm>
#include <fstream>
#include <limits>
#include <sstream>

#if defined(_WIN32)
#undef APIENTRY // our own, for the headers of OpenGL
#define NOMINMAX
#define WIN32_LEAN_AND_MEAN
#include <windows.h>
#elif !defined(__linux__)
#include <unistd.h>
#endif

namespace paradesc {

#if defined(__linux__)

// The number after a name, in "name 17" or "name:   17 kB"; -1 if there is none.
static int64_t number_behind(const std::string &path, const std::string &name) {
  std::ifstream file(path);
  std::string word;
  for (int64_t number = 0; file >> word;) {
    if (word != name) continue;
    return file >> number ? number : -1;
  }
  return -1;
}

// Reads the only number of a file; -1 if there is no such file, or no limit in it ("max").
static int64_t number_in(const std::string &path) {
  std::ifstream file(path);
  int64_t number = 0;
  return file >> number && number >= 0 ? number : -1;
}

struct GroupFiles {
  const char *limit, *used, *reclaimable; // the last is a name in memory.stat
};

// The least number of bytes left in a group and in all groups above it.
static int64_t left_in_group(const std::string &folder, std::string group, const GroupFiles &files) {
  int64_t left = std::numeric_limits<int64_t>::max();
  while (true) {
    const std::string path = folder + (group == "/" ? "" : group) + "/";
    const int64_t limit = number_in(path + files.limit), used = number_in(path + files.used);
    if (limit >= 0 && used >= 0) {
      const int64_t cached = std::max<int64_t>(0, number_behind(path + "memory.stat", files.reclaimable));
      left = std::min(left, std::max<int64_t>(0, limit - std::max<int64_t>(0, used - cached)));
    }
    if (group.empty() || group == "/") return left;
    group.resize(group.rfind('/'));
  }
}

int64_t free_memory(const std::string &root) {
  constexpr GroupFiles version1{"memory.limit_in_bytes", "memory.usage_in_bytes", "total_inactive_file"};
  constexpr GroupFiles version2{"memory.max", "memory.current", "inactive_file"};
  const int64_t available = number_behind(root + "proc/meminfo", "MemAvailable:");
  int64_t left = available < 0 ? std::numeric_limits<int64_t>::max() : available * 1024;
  std::ifstream groups(root + "proc/self/cgroup"); // number:controllers:group
  for (std::string line; std::getline(groups, line);) {
    const size_t first = line.find(':'), second = line.find(':', first + 1);
    if (first == std::string::npos || second == std::string::npos) continue;
    const std::string controllers = "," + line.substr(first + 1, second - first - 1) + ",", group = line.substr(second + 1);
    const std::string folder = root + "sys/fs/cgroup";
    if (controllers == ",,") left = std::min(left, left_in_group(folder, group, version2));
    if (controllers.find(",memory,") != std::string::npos)
      left = std::min(left, left_in_group(folder + "/memory", group, version1));
  }
  return left == std::numeric_limits<int64_t>::max() ? -1 : left;
}

#elif defined(_WIN32)

int64_t free_memory(const std::string &) {
  MEMORYSTATUSEX status{};
  status.dwLength = sizeof status;
  return GlobalMemoryStatusEx(&status) ? static_cast<int64_t>(std::min(status.ullAvailPhys, status.ullAvailVirtual)) : -1;
}

#else

// No portable call reports free memory. macOS compresses and swaps early, so the whole memory is a fair measure.
int64_t free_memory(const std::string &) {
  const long pages = sysconf(_SC_PHYS_PAGES), bytes = sysconf(_SC_PAGESIZE);
  return pages > 0 && bytes > 0 ? int64_t{pages} * bytes : -1;
}

#endif

int64_t allowed_memory(int64_t limit, int64_t held) {
  if (limit > 0) return std::max<int64_t>(0, limit - held);
  const int64_t free = free_memory();
  return free < 0 ? std::numeric_limits<int64_t>::max() : free / 2;
}

} // namespace paradesc
