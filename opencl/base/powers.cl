// Powers and logarithms.

#if LANES > 1
// 2^x for |x| <= 126, relative error 2.2e-7. The built-in functions are more exact, and several times
// slower in vectors.
inline real fast_exp2(real x) {
  x = fast_min(fast_max(x, (real)(-126)), (real)(126));
  real whole = rint(x), f = x - whole;
  real power = 0.00132764715f;
  power = fma(power, f, (real)(0.00967554133f));
  power = fma(power, f, (real)(0.0555071327f));
  power = fma(power, f, (real)(0.240221197f));
  power = fma(power, f, (real)(0.693146967f));
  power = fma(power, f, (real)(1.00000007f));
  return AS_REAL(AS_INTEGER(power) + (TO_INTEGER(whole) << 23));
}

// log2(x) for normal x > 0, absolute error 1e-7 plus the rounding of the result.
inline real fast_log2(real x) {
  // the exponent that leaves a mantissa in [sqrt(1/2), sqrt(2))
  integer exponent = (AS_INTEGER(x) - 0x3f3504f3) >> 23;
  real f = AS_REAL(AS_INTEGER(x) - (exponent << 23)) - 1;
  real series = -0.14575751f;
  series = fma(series, f, (real)(0.236882485f));
  series = fma(series, f, (real)(-0.250061196f));
  series = fma(series, f, (real)(0.28670854f));
  series = fma(series, f, (real)(-0.360088119f));
  series = fma(series, f, (real)(0.480939392f));
  series = fma(series, f, (real)(-0.721357121f));
  series = fma(series, f, (real)(1.44269477f));
  return fma(series, f, TO_REAL(exponent));
}
#else
#define fast_exp2 exp2
#define fast_log2 log2
#endif

// x^alpha for 0 <= x <= 1; the common powers without logarithms. TWICE_ALPHA is a constant: tests of
// alpha cost 5 % of a rigid fit.
inline real power(real x, float alpha) {
#if TWICE_ALPHA == 1
  return sqrt(x);
#elif TWICE_ALPHA == 2
  return x;
#elif TWICE_ALPHA == 3
  return x * sqrt(x);
#elif TWICE_ALPHA == 4
  return x * x;
#elif TWICE_ALPHA == 6
  return x * x * x;
#else
  real result = fast_exp2(alpha * fast_log2(x));
  return select(result, (real)(0), x < FLT_MIN);
#endif
}
