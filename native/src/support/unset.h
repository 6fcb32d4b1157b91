// Vectors for loops that write every element.
#pragma once

#include <memory>
#include <new>
#include <utility>
#include <vector>

namespace paradesc {

// resize() leaves new elements of plain types uninitialized: one core takes longer to zero millions of them than all cores take
// to write them.
template <class T> struct LeaveUnset : std::allocator<T> {
  template <class Other> struct rebind { using other = LeaveUnset<Other>; };
  template <class Item> void construct(Item *place) { ::new (static_cast<void *>(place)) Item; }
  template <class Item, class... From> void construct(Item *place, From &&...from) {
    ::new (static_cast<void *>(place)) Item(std::forward<From>(from)...);
  }
};
template <class T> using UnsetVector = std::vector<T, LeaveUnset<T>>;

} // namespace paradesc
