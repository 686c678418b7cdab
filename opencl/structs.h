// Structs that the host fills and kernels read. vtk_mls/engine/launch/kernel_arguments.py has the same as
// dtypes of numpy; tests/engine/test_structs.py compares them on each device.
//
// A transform is 12 floats: the columns of a matrix, then an offset (`transformed` in types.cl).
// A struct with a long ends with explicit padding: rusticl 22.3 does not count any other.

// A control point: q, the factor of its weight, u = p - q less its mean; local units.
typedef struct {
  float q[3];
  float c;
  float u[3];
  float unused;
} control_point_t;

// The map in a region: how many control points, alpha, and what the kind of maps needs: the rank of
// the control points and the axis of half turns.
typedef struct {
  int count;
  float alpha;
  int rank;
  float flip_axis[3];
} map_numbers_t;

// Displacements in the world: `scale` times local ones, plus the mean displacement.
typedef struct {
  float scale;
  float mean_displacement[3];
} world_t;

// Points `first` to `stop` of a grid with nx x ny points in a layer; `start` is the index of its first
// point in the whole grid, `frame` transforms indices of the whole grid to the local frame.
typedef struct {
  long first, stop;
  int nx, ny;
  int start[3];
  float frame[12];
  int padding;
} grid_t;

// Transforms of indices of the target, and of local displacements, to indices of the source; voids
// are outside of everything unless `continued`.
typedef struct {
  float from_target[12];
  float from_displacement[12];
  int continued;
} source_t;

// The lattice of first guesses for the inverse: the center of its boxes, and 1 / half the size of
// level 0 along each axis.
typedef struct {
  float center[3];
  float density[3];
} lattice_t;

// A sample of the map: v, and its image G(v) less the mean displacement.
typedef struct {
  float v[3];
  float image[3];
} sample_t;

// Nodes of first guesses on a grid: the index of the first, and how many along x and y.
typedef struct {
  int first[3];
  int nx, ny;
} nodes_t;

// Cells of a grid between nodes: `listed` cells from `first_listed` on in a list, or cells
// `first_cell` to `first_cell` + `cells`; `nodes` along the axes, the first at `first_node`;
// `to_slopes` transforms derivatives per index to those per local unit.
typedef struct {
  long first_listed, listed;
  int first_cell[3];
  int cells[3];
  int first_node[3];
  int nodes[3];
  float to_slopes[12];
} coarse_t;

// The check of cells: a transform of local displacements to indices, and the square of the limit.
typedef struct {
  float to_index[12];
  float limit2;
} check_t;

// An array of samples in space: points of the whole source along the axes, the first and the number
// of those in memory, components of each.
typedef struct {
  int size[3];
  int first[3];
  int there[3];
  int components;
} array_t;

// Layers of void distances: points along the axes; layers of points from `first` on, `there` of them,
// are in memory; cells of the layers `start` to `stop` are wanted; `least` is the distance of corners
// that decides.
typedef struct {
  int size[3];
  int first, there, start, stop;
  float least;
} layers_t;

// Layers of an array: points along the axes, the first layer in memory; gradients of the layers
// `start` to `stop` are wanted; `to_world` transforms slopes per index to those per world unit.
typedef struct {
  int size[3];
  int first, start, stop;
  float to_world[12];
} slices_t;

// A full cut: normal and height of the origin, in the local frame and by index of the grid; 1 or -1
// for the side of the region.
typedef struct {
  float plane[4];
  float index_plane[4];
  float side;
} plane_t;

// All cuts: the exponents of the damping, the mean displacement and the affine map from v to x in the
// local frame, the number of full cuts, and whether the launch is for competing regions.
typedef struct {
  float damping, nu;
  float mean_displacement[3];
  float affine[12];
  int plane_count, is_rival;
} cut_numbers_t;
