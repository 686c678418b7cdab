// The polynomials that the affine and polynomial kinds fit: combinations of monomials that the
// host has made orthonormal on the control points (vtk_mls/model/kinds/polynomials.py, Basis).

#ifndef FUNCTIONS
#error "FUNCTIONS is missing: 3, 9 or 19 monomials of degree 1, 2 or 3"
#endif

// Positions of the monomials, named by their factors: XXY is x^2 y.
enum {
  X, Y, Z,
#if FUNCTIONS > 3
  XX, YY, ZZ, XY, XZ, YZ,
#endif
#if FUNCTIONS > 9
  XXX, YYY, ZZZ, XXY, XXZ, XYY, YYZ, XZZ, YZZ, XYZ,
#endif
  MONOMIALS
};

// Monomials at v less those at q, for x = v - q: no digits are lost when x is small.
inline void monomial_differences(vec x, vec v, vec q, real m[MONOMIALS]) {
  m[X] = x.x;
  m[Y] = x.y;
  m[Z] = x.z;
#if FUNCTIONS > 3
  m[XX] = x.x * (v.x + q.x);
  m[YY] = x.y * (v.y + q.y);
  m[ZZ] = x.z * (v.z + q.z);
  m[XY] = fma(x.x, v.y, q.x * x.y);
  m[XZ] = fma(x.x, v.z, q.x * x.z);
  m[YZ] = fma(x.y, v.z, q.y * x.z);
#endif
#if FUNCTIONS > 9
  m[XXX] = x.x * fma(v.x, v.x + q.x, q.x * q.x);
  m[YYY] = x.y * fma(v.y, v.y + q.y, q.y * q.y);
  m[ZZZ] = x.z * fma(v.z, v.z + q.z, q.z * q.z);
  m[XXY] = fma(m[XX], v.y, q.x * q.x * x.y);
  m[XXZ] = fma(m[XX], v.z, q.x * q.x * x.z);
  m[XYY] = fma(m[YY], v.x, q.y * q.y * x.x);
  m[YYZ] = fma(m[YY], v.z, q.y * q.y * x.z);
  m[XZZ] = fma(m[ZZ], v.x, q.z * q.z * x.x);
  m[YZZ] = fma(m[ZZ], v.y, q.z * q.z * x.y);
  m[XYZ] = fma(m[XY], v.z, q.x * q.y * x.z);
#endif
}

// Derivatives of the monomials at v along axis 0, 1 or 2.
inline void monomial_slopes(vec v, int axis, real m[MONOMIALS]) {
  real ex = axis == 0, ey = axis == 1, ez = axis == 2;
  m[X] = ex;
  m[Y] = ey;
  m[Z] = ez;
#if FUNCTIONS > 3
  m[XX] = 2 * v.x * ex;
  m[YY] = 2 * v.y * ey;
  m[ZZ] = 2 * v.z * ez;
  m[XY] = v.y * ex + v.x * ey;
  m[XZ] = v.z * ex + v.x * ez;
  m[YZ] = v.z * ey + v.y * ez;
#endif
#if FUNCTIONS > 9
  m[XXX] = 3 * v.x * v.x * ex;
  m[YYY] = 3 * v.y * v.y * ey;
  m[ZZZ] = 3 * v.z * v.z * ez;
  m[XXY] = v.x * (2 * v.y * ex + v.x * ey);
  m[XXZ] = v.x * (2 * v.z * ex + v.x * ez);
  m[XYY] = v.y * (2 * v.x * ey + v.y * ex);
  m[YYZ] = v.y * (2 * v.z * ey + v.y * ez);
  m[XZZ] = v.z * (2 * v.x * ez + v.z * ex);
  m[YZZ] = v.z * (2 * v.y * ez + v.z * ey);
  m[XYZ] = v.y * v.z * ex + v.x * v.z * ey + v.x * v.y * ez;
#endif
}

// The basis functions f of given monomials (or of their differences or slopes): a row of coefficients
// for each of the `functions`. A pointer as in digit_loss.cl.
inline void combine(__global const float *coefficients, int functions, const real m[MONOMIALS],
                    real *f) {
  for (int j = 0; j < functions; ++j) {
    __global const float *row = coefficients + j * MONOMIALS;
    real sum = row[0] * m[0];
    for (int i = 1; i < MONOMIALS; ++i) sum = fma((real)(row[i]), m[i], sum);
    f[j] = sum;
  }
}
