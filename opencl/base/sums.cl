// Sums whose terms may cancel, of the type SUM. If it is not defined, it is double with USE_FP64, else
// float.

// Value i of a table of `count` floats and, behind them, the same numbers in double.
#ifdef USE_FP64
#pragma OPENCL EXTENSION cl_khr_fp64 : enable
#define WIDEST double
#define WIDEST_VALUE(table, count, i) as_double(vload2(i, (table) + (count)))
#else
#define WIDEST float
#define WIDEST_VALUE(table, count, i) (table)[i]
#endif
#ifndef SUM
#define SUM WIDEST
#endif

typedef OF_LANES(SUM) sum_t;
#if LANES == 1
#define TO_SUM(x) ((SUM)(x))
#define SUM_TO_REAL(sum) ((float)(sum))
#else
#define TO_SUM(x) __builtin_convertvector(x, sum_t)
#define SUM_TO_REAL(sum) __builtin_convertvector(sum, real)
#endif
#define LANE_SUM(vector, l) (((SUM *)&(vector))[l])
