// Structs and constants shared by host and kernels. vtk_mls/engine/launch/kernel_arguments.py reads
// this file and makes numpy dtypes of the structs; tests/engine/test_kernel_functions.py compares
// them on each device.
//
// A transform is 12 floats: the columns of a matrix, then an offset (`transformed` in types.cl).
// A struct with a long ends with explicit padding: rusticl 22.3 does not count any other.

enum {
  NODE_STEP = 4,       // grid points between nodes of first guesses (origin_nodes.cl)
  COARSE_STEP = 4,     // grid points between nodes of displacements (coarse_map.cl)
  BAND_CELLS = 8,      // cells along y of a work item between these nodes
  LATTICE_CELLS = 20,  // cells along each axis of a level of the lattice (lattice.cl)
  LATTICE_LEVELS = 8,
  CELL_ROWS = 4,       // rows and layers of cells of a work item (void_by_corners.cl)
  CELL_LAYERS = 16,
  VOXEL_ROWS = 32,     // rows of voxels of a work item (doubtful_voxels.cl)
  // bits of the result of void_by_corners.cl: the cell center is void; a corner is; undecided
  VOID = 1,
  TOUCHED = 2,
  UNKNOWN = 4,
  // forms of limit_t
  BOX_MASK = 0,
  IMAGE_MASK = 1,
  PLANE_FACE = 2,
  IMAGE_FACE = 3,
  // bits of the result of coarse_check.cl: interpolation is inaccurate; no point is in the region; cells
  // beside it count as inaccurate, too
  INACCURATE = 1,
  OTHER_REGION = 2,
  SPREADS = 4
};

// A control point, local units: q, the factor c of its weight, u = p - q less its mean. The first
// ones are the means of the proxies of each rigid region; the proxies follow after all others.
typedef struct {
  float q[3];
  float c;
  float u[3];
} control_point_t;

// A rigid region after its motion, local units: the points within `radius` of the segment from
// `end` along `along`, or those with a distance below 0 in an image. Cuts see it at `anchor`. Of its
// proxies about their mean, `moments` are the weighted means of p q^T, and `spread` that of |q|^2.
typedef struct {
  float end[3], along[3], radius;
  float anchor[3];
  float step;           // cell size of the image, 0 for a capsule
  float to_index[12];   // from the local frame to indices of the image
  int size[3];          // points of the image along each axis
  float last[3];        // size - 1
  int first;            // its first value in `images`
  int border;           // the first value of its border (regions.cl)
  float row, face;      // values of a row of the border, and of a face
  int first_proxy, proxy_count;
  float moments[9], spread;
} region_t;

// A segment of a curve, local units: q and u = p - q less its mean, at its start and their change to
// its end; the factor c of its weight; 1 / squared length, and squared length.
typedef struct {
  float q[3], along_q[3];
  float u[3], along_u[3];
  float c, density, length2;
} segment_t;

// A mask or a face, local units. A mask is the points within `radius` of the box from `low` to `high`,
// or those with values above 0 in an image. A face is the plane of normal `low` with height `high[0]` of
// the origin, or the points with a distance of 0 in an image.
typedef struct {
  int form, slides;     // BOX_MASK, ...; whether material slides along a face
  float low[3], high[3], radius, falloff;
  float to_index[12];   // as of region_t
  int size[3];
  int first;
} limit_t;

// The map of a region: numbers of control points without proxies, of rigid regions, segments, limits
// and steps; alpha, square of the smoothing length, rank of the set of control points, and the axis
// of half turns (rigid and similarity kinds). In the buffer `map_tables`, which begins with the control
// points, the other tables begin at the floats `kind_start`, ...
typedef struct {
  int count, region_count, segment_count, limit_count, step_count;
  int kind_start, region_start, segment_start, limit_start, image_start, step_start;
  float alpha, smoothing2;
  int rank;
  float flip_axis[3];
} map_params_t;

// A step of the map: where its records begin in the tables; its rank and axis, as of map_params_t.
typedef struct {
  int control_point, kind_value, region, segment;
  int rank;
  float flip_axis[3];
} step_t;

// World displacement = scale * local displacement + mean_displacement.
typedef struct {
  float scale;
  float mean_displacement[3];
} world_t;

// The local frame: the center as the sum of two floats, for more digits than float has.
typedef struct {
  float center[3];
  float center_rest[3];
} local_frame_t;

// Points `first` to `stop` (exclusive) of a grid with nx x ny points per layer. `start` is the index
// of its first point in the whole grid; `frame` transforms whole-grid indices to the local frame.
typedef struct {
  long first, stop;
  int nx, ny;
  int start[3];
  float frame[12];
  int padding;
} grid_t;

// Transforms of target indices, and of local displacements, to source indices. Voids map outside of
// the source unless `continued`.
typedef struct {
  float from_target[12];
  float from_displacement[12];
  int continued;
} source_t;

// The lattice of first guesses for the inverse: center of its boxes, 1 / half the size of level 0.
typedef struct {
  float center[3];
  float density[3];
} lattice_t;

// A sample of the map: v, and G(v) less the mean displacement.
typedef struct {
  float v[3];
  float image[3];
} sample_t;

// Nodes of first guesses on a grid: index of the first node, number of nodes along x and y.
typedef struct {
  int first[3];
  int nx, ny;
} nodes_t;

// A node: origin x, and its change from node to node along i, j, k. x.w is the norm of dG/dx, below 0
// behind a cut; by_i.w that of the cell above, below 0 where the cell gives no guess (node_cell.cl).
typedef struct {
  float4 x, by_i, by_j, by_k;
} node_t;

// Cells of a grid between nodes: entries `first_listed` to `first_listed + listed` of a list, or a
// box of `cells` cells from `first_cell` on. `nodes` nodes along the axes, the first at `first_node`.
// `to_slopes` transforms derivatives per index to derivatives per local unit.
typedef struct {
  long first_listed, listed;
  int first_cell[3];
  int cells[3];
  int first_node[3];
  int nodes[3];
  float to_slopes[12];
} coarse_t;

// The check of cells: transform of local displacements to indices, square of the limit.
typedef struct {
  float to_index[12];
  float limit2;
} check_t;

// An array of samples: points of the whole source, first point and number of points in memory along
// each axis, components per point.
typedef struct {
  int size[3];
  int first[3];
  int stored[3];
  int components;
} array_t;

// Layers of void distances: points along the axes; the point layers in memory are `stored` from
// `first` on; the cell layers to compute are `start` to `stop`. A corner decides if its distance is
// at least `min_distance` and `far_factor` times the differences nearby.
typedef struct {
  int size[3];
  int first, stored, start, stop;
  float min_distance, far_factor;
} layers_t;

// Points of a displacement field along the axes; the steps between neighbors, three floats each; 1 / the
// volume of a voxel. A voxel is doubtful if its smallest tetrahedron is not above `share` of all six.
typedef struct {
  int size[3];
  float axes[9], inverse_volume, share;
} voxels_t;

// Layers of an array: points along the axes, first layer in memory, layers `start` to `stop` to
// compute. `to_world` transforms slopes per index to slopes per world unit.
typedef struct {
  int size[3];
  int first, start, stop;
  float to_world[12];
} slices_t;

// A full cut: normal and height of the origin, in the local frame and in whole-grid indices; `side`
// is 1 or -1 for the side of the region.
typedef struct {
  float plane[4];
  float index_plane[4];
  float side;
} plane_t;

// All cuts: exponents of the damping, relative distance that counts as on a plane, mean displacement
// and affine map from v to x in the local frame, number of full cuts. Regions compete where full cuts
// belong to the material (on_grid.cl); the second pass computes the points that are void so far. In the
// buffer `cut_tables`, which begins with the full cuts, obstacles begin at the float `obstacle_start`;
// `obstacle_stride` is the size of the tables of a step, 0 if all steps have the same.
typedef struct {
  float damping, nu, on_plane;
  float mean_displacement[3];
  float affine[12];
  int plane_count, regions_compete, second_pass, obstacle_start, obstacle_stride;
} cut_params_t;
