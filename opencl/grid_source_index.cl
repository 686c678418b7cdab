#include "source_index.cl"

KERNEL void grid_source_index(MAP_PARAMETERS, GRID_PARAMETERS, SOURCE_PARAMETERS) {
  FIT_ON_GRID
  STORE_SOURCE_INDEX
}
