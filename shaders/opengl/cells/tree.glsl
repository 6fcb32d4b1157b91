// The tree of cells, each node stored before its children. A node of level n has 4^n consecutive cells; cells are level 0.
#define CELLS_OF_LEVEL(level) (1 << TREE_BITS * (level))

// The number of nodes stored before a cell.
int nodes_before(int cell) {
  int nodes = cell;
  for (int level = 1; level <= search.top_level; ++level) nodes += (cell + CELLS_OF_LEVEL(level) - 1) >> TREE_BITS * level;
  return nodes;
}

// The index of node i of a level.
int node_at(int level, int i) {
  int first = i << TREE_BITS * level, node = nodes_before(first);
  for (int above = level + 1; above <= search.top_level; ++above)
    if ((first & CELLS_OF_LEVEL(above) - 1) == 0) ++node;
  return node;
}

// The index after node i of a level and all its descendants.
int node_after(int level, int i) { return nodes_before(min(i + 1 << TREE_BITS * level, search.cell_count)); }
