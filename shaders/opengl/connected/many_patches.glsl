// The patches of a flood if they may be many: a hash table with open addressing, and a queue.
#define FLOOD_PLACES (2 * FLOOD_PATCHES)
int patch_at[FLOOD_PLACES];                            // -1: none
uint reached_at[FLOOD_PLACES], pending_at[FLOOD_PLACES]; // bits of triangles: visited, and still to be visited
int queue[FLOOD_PATCHES];                              // circular: places of patches with pending triangles
int patches, first_queued, queued;

void begin_flood() {
  patches = first_queued = queued = 0;
  for (int i = 0; i < FLOOD_PLACES; ++i) patch_at[i] = -1;
}

// Marks triangles of a patch as pending. Returns false if there is no room.
bool reach(int patch_number, uint bits) {
  int place = first_place(patch_number, FLOOD_PLACES), found = patch_at[place];
  while (found >= 0 && found != patch_number) {
    place = place + 1 & FLOOD_PLACES - 1;
    found = patch_at[place];
  }
  uint reached = 0u, pending = 0u;
  if (found < 0) {
    if (++patches > FLOOD_PATCHES) return false;
    patch_at[place] = patch_number;
    reached_at[place] = 0u;
  } else {
    reached = reached_at[place];
    pending = pending_at[place];
  }
  uint fresh = bits & ~(reached | pending);
  if (pending == 0u && fresh != 0u) queue[first_queued + queued++ & FLOOD_PATCHES - 1] = place;
  pending_at[place] = pending | fresh;
  return true;
}

// Stores the patch at a place, if there is one, and takes the next one with pending triangles. Returns false if there is none.
bool next_patch(inout int place, inout int patch_number, inout uint reached, out uint pending) {
  pending = 0u;
  if (place >= 0) reached_at[place] = reached;
  if (queued == 0) return false;
  place = queue[first_queued];
  first_queued = first_queued + 1 & FLOOD_PATCHES - 1;
  --queued;
  patch_number = patch_at[place];
  reached = reached_at[place];
  pending = pending_at[place];
  pending_at[place] = 0u;
  return true;
}

int patch_in(int place) { return patch_at[place]; }
uint reached_in(int place) { return reached_at[place]; }
