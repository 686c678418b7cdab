// Images of distances and masks: values at the points of a grid, linear between them.

// The value at `index`, which is limited to the grid, and its change per step.
inline real image_value(__global const float *values, __global const int *size, vec index,
                        vec *slope) {
  real value;
  for (int l = 0; l < LANES; ++l) {
    const int i = clamp((int)LANE(index.x, l), 0, size[0] - 2),
              j = clamp((int)LANE(index.y, l), 0, size[1] - 2),
              k = clamp((int)LANE(index.z, l), 0, size[2] - 2);
    const float a = clamp(LANE(index.x, l) - i, 0.0f, 1.0f),
                b = clamp(LANE(index.y, l) - j, 0.0f, 1.0f),
                c = clamp(LANE(index.z, l) - k, 0.0f, 1.0f);
    __global const float *low = values + i + size[0] * (j + size[1] * k);
    __global const float *high = low + size[0] * size[1];
    const float x00 = low[1] - low[0], x10 = low[size[0] + 1] - low[size[0]],
                x01 = high[1] - high[0], x11 = high[size[0] + 1] - high[size[0]];
    const float v00 = fma(a, x00, low[0]), v10 = fma(a, x10, low[size[0]]),
                v01 = fma(a, x01, high[0]), v11 = fma(a, x11, high[size[0]]);
    const float y0 = v10 - v00, y1 = v11 - v01, w0 = fma(b, y0, v00), w1 = fma(b, y1, v01);
    const float x0 = fma(b, x10 - x00, x00), x1 = fma(b, x11 - x01, x01);
    LANE(value, l) = fma(c, w1 - w0, w0);
    LANE(slope->x, l) = fma(c, x1 - x0, x0);
    LANE(slope->y, l) = fma(c, y1 - y0, y0);
    LANE(slope->z, l) = w1 - w0;
  }
  return value;
}

// The continuous index of a local v.
inline vec index_in_image(__global const float *to_index, vec v) {
  float transform[12];
  for (int i = 0; i < 12; ++i) transform[i] = to_index[i];
  return transformed(transform, v);
}

// The index limited to the grid; `beyond` is what was taken off.
inline vec limited_index(__global const int *size, vec index, vec *beyond) {
  vec inside = {least(most(index.x, (real)(0)), (real)(size[0] - 1)),
                least(most(index.y, (real)(0)), (real)(size[1] - 1)),
                least(most(index.z, (real)(0)), (real)(size[2] - 1))};
  *beyond = vec_sub(index, inside);
  return inside;
}

// Slopes per index as slopes per local unit.
inline vec by_index(__global const float *to_index, vec slope) {
  return (vec){to_index[0] * slope.x + to_index[1] * slope.y + to_index[2] * slope.z,
               to_index[3] * slope.x + to_index[4] * slope.y + to_index[5] * slope.z,
               to_index[6] * slope.x + to_index[7] * slope.y + to_index[8] * slope.z};
}

// A vector of index steps in the local frame, where steps are of one length in all directions:
// the transposed matrix of `to_index`, times `step` twice.
inline vec from_steps(__global const float *to_index, float step, vec a) {
  return vec_scale((real)(step * step), by_index(to_index, a));
}
