// What the lists of a search are made with, how long they are, and how long they may be.
#include "shared.h"
layout(std140, binding = BLOCK_SEARCH) uniform Search { SearchParams search; };
layout(std430, binding = BINDING_COUNTS) restrict buffer Counts { SearchCounts counts; };

// Whether the lists of samples and cells have room, or all lists. They are made longer otherwise, and the search begins again.
bool cells_fit() {
  return counts.samples <= search.room.samples && counts.fine <= search.room.fine && counts.cells <= search.room.cells &&
         counts.longest <= search.room.longest;
}

bool lists_fit() { return cells_fit() && counts.neighbors <= search.room.neighbors; }
