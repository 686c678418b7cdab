// The polynomials that the affine and polynomial kinds fit: combinations of monomials that the
// host has made orthonormal on the control points (vtk_mls/kinds/polynomials.py, Basis).

#ifndef FUNCTIONS
#error "FUNCTIONS is missing: 3, 9 or 19 for degree 1, 2 or 3"
#endif
#define MONOMIALS FUNCTIONS

// Monomials at v less those at q, for x = v - q: no digits are lost when x is small.
inline void monomial_differences(vec x, vec v, vec q, real m[MONOMIALS]) {
  m[0] = x.x;
  m[1] = x.y;
  m[2] = x.z;
#if MONOMIALS > 3
  m[3] = x.x * (v.x + q.x);
  m[4] = x.y * (v.y + q.y);
  m[5] = x.z * (v.z + q.z);
  m[6] = fma(x.x, v.y, q.x * x.y);
  m[7] = fma(x.x, v.z, q.x * x.z);
  m[8] = fma(x.y, v.z, q.y * x.z);
#endif
#if MONOMIALS > 9
  m[9] = x.x * fma(v.x, v.x + q.x, q.x * q.x);
  m[10] = x.y * fma(v.y, v.y + q.y, q.y * q.y);
  m[11] = x.z * fma(v.z, v.z + q.z, q.z * q.z);
  m[12] = fma(m[3], v.y, q.x * q.x * x.y);
  m[13] = fma(m[3], v.z, q.x * q.x * x.z);
  m[14] = fma(m[4], v.x, q.y * q.y * x.x);
  m[15] = fma(m[4], v.z, q.y * q.y * x.z);
  m[16] = fma(m[5], v.x, q.z * q.z * x.x);
  m[17] = fma(m[5], v.y, q.z * q.z * x.y);
  m[18] = fma(m[6], v.z, q.x * q.y * x.z);
#endif
}

// Derivatives of the monomials at v along axis 0, 1 or 2.
inline void monomial_slopes(vec v, int axis, real m[MONOMIALS]) {
  real ex = axis == 0, ey = axis == 1, ez = axis == 2;
  m[0] = ex;
  m[1] = ey;
  m[2] = ez;
#if MONOMIALS > 3
  m[3] = 2 * v.x * ex;
  m[4] = 2 * v.y * ey;
  m[5] = 2 * v.z * ez;
  m[6] = v.y * ex + v.x * ey;
  m[7] = v.z * ex + v.x * ez;
  m[8] = v.z * ey + v.y * ez;
#endif
#if MONOMIALS > 9
  m[9] = 3 * v.x * v.x * ex;
  m[10] = 3 * v.y * v.y * ey;
  m[11] = 3 * v.z * v.z * ez;
  m[12] = v.x * (2 * v.y * ex + v.x * ey);
  m[13] = v.x * (2 * v.z * ex + v.x * ez);
  m[14] = v.y * (2 * v.x * ey + v.y * ex);
  m[15] = v.y * (2 * v.z * ey + v.y * ez);
  m[16] = v.z * (2 * v.x * ez + v.z * ex);
  m[17] = v.z * (2 * v.y * ez + v.z * ey);
  m[18] = v.y * v.z * ex + v.x * v.z * ey + v.x * v.y * ez;
#endif
}

// The basis functions of given monomials (or of their differences or slopes): a row of coefficients
// for each of the `functions`.
inline void combine(__global const float *coefficients, int functions, const real m[MONOMIALS],
                    real f[FUNCTIONS]) {
  for (int j = 0; j < functions; ++j) {
    __global const float *row = coefficients + j * MONOMIALS;
    real sum = row[0] * m[0];
    for (int i = 1; i < MONOMIALS; ++i) sum = fma((real)(row[i]), m[i], sum);
    f[j] = sum;
  }
}
