// Values of an array, as interpolation sums them.
//
// Sums in float are of the values themselves. Sums in double are of their differences from a pivot,
// the nearest value, to which the sum is added: a constant stays the same to the bit, and 64-bit
// integers keep the digits that double does not have.

#if !defined(VALUE) || !defined(IS_INTEGER)
#error "VALUE or IS_INTEGER is missing: type of the array"
#endif

// Vector of LANES values, and the conversion of sums to it; integers are rounded and clamped.
#define VALUES OF_LANES(VALUE)
#define ROUNDING_0
#define ROUNDING_1 _sat_rte
#define CAST GLUE(GLUE(convert_, VALUES), GLUE(ROUNDING_, IS_INTEGER))

#define LANE_VALUE(values, l) (((VALUE *)&(values))[l])

#ifdef USE_FP64
#define HAS_PIVOT 1
#else
#define HAS_PIVOT 0
#endif

#define BITS64_long 1
#define BITS64_ulong 1
#define IS_INTEGER64 (HAS_PIVOT && GLUE(BITS64_, VALUE))

// Values of taps: of 64-bit integers as they are, of others as the sums have them.
#if IS_INTEGER64
#define TAP VALUE
#define TO_TAP(x) (x)
typedef VALUES tap_t;
#else
#define TAP SUM
#define TO_TAP(x) TO_SUM(x)
typedef sum_t tap_t;
#endif
#define LANE_TAP(vector, l) (((TAP *)&(vector))[l])

inline tap_t gathered(__global const VALUE *values, offset_t from) {
  tap_t taps;
  UNROLL_ALL for (int l = 0; l < LANES; ++l) LANE_TAP(taps, l) = (TAP)values[LANE_OFFSET(from, l)];
  return taps;
}

// The part of a tap that is summed. The difference of 64-bit integers has up to 65 bits: those of
// the upper and lower halves have 33, and their sum is rounded once.
#if IS_INTEGER64
#define TERM(to_sum, to_long, tap, pivot)                                \
  (to_sum(to_long((tap) >> 32) - to_long((pivot) >> 32)) * 4294967296.0 + \
   to_sum(to_long((tap) & 0xffffffff) - to_long((pivot) & 0xffffffff)))
#elif HAS_PIVOT
#define TERM(to_sum, to_long, tap, pivot) ((tap) - (pivot))
#else
#define TERM(to_sum, to_long, tap, pivot) (tap)
#endif
#define TO_LONG(x) GLUE(convert_, OF_LANES(long))(x)

#if IS_INTEGER64
typedef OF_LANES(ulong) bits_t;
#define TO_BITS(x) GLUE(as_, OF_LANES(ulong))(x)
#define TO_COUNT(x) GLUE(GLUE(convert_, OF_LANES(ulong)), _sat_rte)(x)
#define SIGN_long 0x8000000000000000ul
#define SIGN_ulong 0ul

// pivot + sum, rounded to the nearest (ties to even) and kept in range. With its sign bit flipped a
// signed integer is ordered as an unsigned one, whose range holds every difference.
HOT VALUES rounded_sum(tap_t pivot, sum_t sum) {
  const bits_t bits = TO_BITS(pivot) ^ GLUE(SIGN_, VALUE), odd = bits & 1;
  sum += TO_SUM(odd);
  const bits_t up = TO_COUNT(fmax(sum, (sum_t)(0))), down = TO_COUNT(fmax(-sum, (sum_t)(0)));
  return GLUE(as_, VALUES)(sub_sat(add_sat(bits - odd, up), down) ^ GLUE(SIGN_, VALUE));
}
#endif
