// Values of an array at continuous indices. The rules are those of vtk_mls/interpolation.py.
// Build constants: README.md.

#if !defined(VALUE) || !defined(SUM) || !defined(CAST) || !defined(TAPS)
#error "VALUE, SUM, CAST or TAPS is missing"
#endif
#ifdef USE_FP64
#pragma OPENCL EXTENSION cl_khr_fp64 : enable
#endif

// Weights of the taps along one axis at the fraction t: two for linear, four for Catmull-Rom.
inline void tap_weights(float t, float w[TAPS]) {
#if TAPS == 2
  w[0] = 1 - t;
  w[1] = t;
#elif TAPS == 4
  w[0] = 0.5f * t * fma(t, 2 - t, -1.0f);
  w[1] = 0.5f * fma(t * t, fma(3.0f, t, -5.0f), 2.0f);
  w[2] = 0.5f * t * fma(t, fma(-3.0f, t, 4.0f), 1.0f);
  w[3] = 0.5f * t * t * (t - 1);
#else
  w[0] = 1;
#endif
}

// `index` holds three planes of `count` indices. Of the source, whose size is nx, ny, nz, the
// slices from `slice` on are in `values`.
__kernel void resample(const long count, __global const float *restrict index, const int nx,
                       const int ny, const int nz, const int slice, const int components,
                       const VALUE background, __global const VALUE *restrict values,
                       __global VALUE *restrict result) {
  long n = get_global_id(0);
  if (n >= count) return;
  __global VALUE *to = result + n * components;
  float x = index[n], y = index[count + n], z = index[2 * count + n];
  if (!(x >= -0.5f && y >= -0.5f && z >= -0.5f && x <= nx - 0.5f && y <= ny - 0.5f &&
        z <= nz - 0.5f)) {
    for (int c = 0; c < components; ++c) to[c] = background;
    return;
  }
  x = clamp(x, 0.0f, (float)(nx - 1));
  y = clamp(y, 0.0f, (float)(ny - 1));
  z = clamp(z, 0.0f, (float)(nz - 1));
  int i = (int)x, j = (int)y, k = (int)z;
  float tx = x - i, ty = y - j, tz = z - k;
  long step_y = (long)nx * components, step_z = step_y * ny;
  if (TAPS == 1 || (tx == 0 && ty == 0 && tz == 0)) {  // to the bit
    i += tx >= 0.5f;
    j += ty >= 0.5f;
    k += tz >= 0.5f;
    __global const VALUE *at = values + (k - slice) * step_z + j * step_y + (long)i * components;
    for (int c = 0; c < components; ++c) to[c] = at[c];
    return;
  }
  float wx[TAPS], wy[TAPS], wz[TAPS];
  tap_weights(tx, wx);
  tap_weights(ty, wy);
  tap_weights(tz, wz);
  long ox[TAPS], oy[TAPS], oz[TAPS];
  for (int tap = 0; tap < TAPS; ++tap) {
    int off = tap - (TAPS - 1) / 2;
    ox[tap] = (long)clamp(i + off, 0, nx - 1) * components;
    oy[tap] = clamp(j + off, 0, ny - 1) * step_y;
    oz[tap] = (clamp(k + off, 0, nz - 1) - slice) * step_z;
  }
  for (int c = 0; c < components; ++c) {
    SUM sum = 0;
    for (int kk = 0; kk < TAPS; ++kk)
      for (int jj = 0; jj < TAPS; ++jj) {
        __global const VALUE *line = values + oz[kk] + oy[jj] + c;
        float wyz = wy[jj] * wz[kk];
        for (int ii = 0; ii < TAPS; ++ii) {
          float w = wx[ii] * wyz;
          // a tap without weight must not bring in its NaN or infinity
          if (w != 0) sum += (SUM)w * (SUM)line[ox[ii]];
        }
      }
    to[c] = CAST(sum);
  }
}
